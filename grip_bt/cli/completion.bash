_grip_words() {
    case $1 in
@CASES@
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
