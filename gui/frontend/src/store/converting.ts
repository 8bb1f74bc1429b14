/** Conversion to the other form: looked at, compared, and only then done, as one edit. */
import { KINDS } from "../model/words";
import { server } from "../protocol/client";
import type { ConversionView } from "../protocol/generated";
import { askChoice, type Option } from "./ask";
import { openTask } from "./desk";
import { useDocument } from "./document";
import { convert } from "./editing";
import { usePage } from "./page";
import { keepPlays, showPlay, SIDES, sideOf } from "./plays";
import { useRun } from "./run";

type Form = "tree" | "machine";

/** What a person can ask for: a form, and whether what then isn't the same comes along. */
interface Wish {
  readonly path: string;
  readonly node: string;
  readonly name: string;
  readonly form: Form;
  readonly approximate: boolean;
}

export async function askConversion(node = usePage.getState().selected ?? "/"): Promise<void> {
  const { document } = useDocument.getState();
  const view = useRun.getState().index.byPath.get(node);
  if (document === null || view === undefined) return;
  const chosen = await askForm(view.name, view.kind);
  if (chosen === null) return;
  const form: Form = chosen === "tree" ? "tree" : "machine";
  const wish: Wish = { path: document.path, node, name: view.name, form, approximate: chosen === ROUGHLY };
  try {
    await decide(wish, await server.conversion(wish.path, node, form, wish.approximate));
  } catch (error) {
    useRun.getState().setTrouble(error instanceof Error ? error.message : String(error));
  }
}

/** What was found is shown; the person plays it, converts, or leaves it. */
async function decide(wish: Wish, found: ConversionView): Promise<void> {
  const plays: Option[] = SIDES.map(([side, label], i) => ({
    value: side,
    label: `Play it ${label.toLowerCase()}`,
    detail: `The counterexample on the time line: ${(i === 0 ? found.does_before : found.does_after).at(-1) ?? ""}`,
  }));
  const answer = await askChoice({
    title: `${wish.name} as a ${WORDS[wish.form]}`,
    label: "What to do",
    lead: leadOf(found),
    columns: [
      { title: `Now (${found.before.length} nodes)`, lines: found.before },
      { title: `Then (${found.after.length} nodes)`, lines: found.after },
    ],
    options: [
      ...(found.plays.length > 0 ? plays : []),
      { value: "yes", label: found.same ? "Convert" : "Convert all the same", detail: "One edit, which undo takes back to the byte" },
      { value: "no", label: "Leave it as it is" },
    ],
  });
  if (answer === "now" || answer === "then") {
    keepPlays(found, () => void decide(wish, found));
    showPlay(answer);
    return;
  }
  if (answer === null) return;
  if (sideOf(useRun.getState().record) !== null) await openTask(wish.path, wish.node);
  if (answer === "yes") await convert(wish.node, wish.form, wish.approximate);
}

const ROUGHLY = "roughly";

const WORDS: Record<Form, string> = { tree: "behaviour tree", machine: "state machine" };

async function askForm(name: string, kind: string): Promise<string | null> {
  const options = [
    { value: "tree", label: "To a behaviour tree", detail: "State machines in it become sequences, fallbacks and loops, where they have a structure" },
    { value: "machine", label: "To a state machine", detail: "Sequences, fallbacks and loops in it become states and edges" },
  ];
  if (kind !== "state_machine") options.reverse();
  options.push({ value: ROUGHLY, label: "To a state machine, roughly", detail: "Also what asks again on every tick, as one that remembers: a counterexample shows the difference" });
  return askChoice({ title: `Convert ${name} (${KINDS[kind] ?? kind})`, label: "Form", options });
}

function leadOf(found: ConversionView): string {
  const kept = found.kept.length > 0 ? ` ${found.kept.join("; ")}.` : "";
  if (found.same) return `Both forms are ${found.compared}.${kept}`;
  return `They are not the same. When ${found.script.join(", ")}: now ${found.does_before.join(", ")}; then ${found.does_after.join(", ")}.${kept}`;
}
