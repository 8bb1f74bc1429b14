_grip_words() {
    case $1 in
        "") echo "demo new check fmt apply run convert import component interfaces launch sim messages serve edit runs bench replay robot object world teach docs doctor completion help" ;;
        "demo") echo "--help clear_table reactive explore unscrew pipette benchmark --as --robot --seed --pace --world --fault --video --picture --view --json --gui --port --no-browser --quiet --verbose" ;;
        "demo --as") echo "bt sm" ;;
        "demo --robot") echo "sim fake ros" ;;
        "new") echo "--help --robot --world --configuration --ros --quiet --verbose" ;;
        "check") echo "--help --strict --json --schema --quiet --verbose" ;;
        "fmt") echo "--help --check --json --quiet --verbose" ;;
        "apply") echo "--help --dry-run --quiet --verbose" ;;
        "run") echo "--help --as --robot --seed --pace --world --fault --video --picture --view --set --journal --json --rate --ticks --watchdog --stand-ins --mock --mocks --control --in-process --no-code --resume --fork --at --set-outcome --yes --quiet --verbose" ;;
        "run --as") echo "bt sm" ;;
        "run --robot") echo "sim fake ros" ;;
        "convert") echo "--help --to --view --strict --execute --stand-ins --output --quiet --verbose" ;;
        "convert --to") echo "bt btcpp dot mermaid pytrees-py pytrees-xml sm smach-py svg yaml" ;;
        "convert --view") echo "tree flow" ;;
        "import") echo "--help --from --output --machine --execute --stand-ins --arguments --success --report --json --no-code --quiet --verbose" ;;
        "import --from") echo "btcpp grip pytrees smach" ;;
        "component") echo "--help new add list test --quiet --verbose" ;;
        "component new") echo "--help --lang --folder --quiet --verbose" ;;
        "component --lang") echo "python cpp" ;;
        "component add") echo "--help --from-graph --outcomes --failure --name --server --interfaces --project --wait --check --quiet --verbose" ;;
        "component list") echo "--help --json --quiet --verbose" ;;
        "component test") echo "--help --json --no-code --quiet --verbose" ;;
        "interfaces") echo "--help build --quiet --verbose" ;;
        "interfaces build") echo "--help --json --quiet --verbose" ;;
        "launch") echo "--help --project --follow --check --write --json --no-code --quiet --verbose" ;;
        "sim") echo "--help --project --seed --pace --camera-rate --room --simulated-time --setup --quiet --verbose" ;;
        "messages") echo "--help serve list show take watch add push delete reset save --quiet --verbose" ;;
        "messages serve") echo "--help --project --quiet --verbose" ;;
        "messages list") echo "--help --json --quiet --verbose" ;;
        "messages show") echo "--help --message --json --quiet --verbose" ;;
        "messages take") echo "--help --message --json --quiet --verbose" ;;
        "messages watch") echo "--help --count --json --quiet --verbose" ;;
        "messages add") echo "--help --file --topic --within --type --by --quiet --verbose" ;;
        "messages push") echo "--help --file --topic --within --type --by --quiet --verbose" ;;
        "messages delete") echo "--help --quiet --verbose" ;;
        "messages reset") echo "--help --quiet --verbose" ;;
        "messages save") echo "--help --quiet --verbose" ;;
        "serve") echo "--help --robot --name --setup --managed --quiet --verbose" ;;
        "serve --robot") echo "ros sim fake" ;;
        "edit") echo "--help --execute --stand-ins --port --no-browser --study --no-code --quiet --verbose" ;;
        "runs") echo "--help --journal --json --to --output --data --prune --quiet --verbose" ;;
        "runs --to") echo "jsonl csv mcap rerun lerobot" ;;
        "bench") echo "--help --workers --cluster --resume --fresh --trial --pictures --output --no-code --json --csv --quiet --verbose" ;;
        "replay") echo "--help --journal --speed --until --step --json --gui --no-browser --quiet --verbose" ;;
        "robot") echo "--help check show list --quiet --verbose" ;;
        "robot check") echo "--help --srdf --arg --package --json --quiet --verbose" ;;
        "robot show") echo "--help --srdf --arg --package --json --quiet --verbose" ;;
        "robot list") echo "--help --json --quiet --verbose" ;;
        "object") echo "--help list show check add --quiet --verbose" ;;
        "object list") echo "--help --json --quiet --verbose" ;;
        "object show") echo "--help --picture --json --quiet --verbose" ;;
        "object check") echo "--help --json --quiet --verbose" ;;
        "object add") echo "--help --name --scale --mass --friction --parts --quiet --verbose" ;;
        "world") echo "--help list show check new --quiet --verbose" ;;
        "world list") echo "--help --json --quiet --verbose" ;;
        "world show") echo "--help --seed --picture --camera --json --quiet --verbose" ;;
        "world check") echo "--help --json --quiet --verbose" ;;
        "world new") echo "--help --like --quiet --verbose" ;;
        "teach") echo "--help --project --arm --hand --pose --robot --json --quiet --verbose" ;;
        "teach --robot") echo "ros sim" ;;
        "docs") echo "--help --port --no-browser --quiet --verbose" ;;
        "doctor") echo "--help --json --fix --quiet --verbose" ;;
        "completion") echo "--help bash zsh fish --quiet --verbose" ;;
        "help") echo "--help demo new check fmt apply run convert import component interfaces launch sim messages serve edit runs bench replay robot object world teach docs doctor completion help all --quiet --verbose" ;;
    esac
}
_grip() {
    local word=${COMP_WORDS[COMP_CWORD]} verb= action= before= found= at
    [ "$COMP_CWORD" -gt 1 ] && verb=${COMP_WORDS[1]} before=${COMP_WORDS[COMP_CWORD-1]}
    [ "$COMP_CWORD" -gt 2 ] && action=${COMP_WORDS[2]}
    for at in "$verb $before" "$verb $action" "$verb"; do
        found=$(_grip_words "$at")
        [ -n "$found" ] && break
    done
    COMPREPLY=($(compgen -W "$found" -- "$word"))
}
complete -o default -F _grip grip
