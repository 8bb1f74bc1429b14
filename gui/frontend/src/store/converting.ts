/** Conversion to the other form: looked at, compared, and only then done, as one edit. */
import { KINDS } from "../model/words";
import { server } from "../protocol/client";
import type { ConversionView } from "../protocol/generated";
import { askChoice } from "./ask";
import { useDocument } from "./document";
import { convert } from "./editing";
import { usePage } from "./page";
import { useRun } from "./run";

type Form = "tree" | "machine";

export async function askConversion(node = usePage.getState().selected ?? "/", wanted?: Form): Promise<void> {
  const { document } = useDocument.getState();
  const view = useRun.getState().index.byPath.get(node);
  if (document === null || view === undefined) return;
  const form = wanted ?? (await askForm(view.name, view.kind));
  if (form === null) return;
  let found: ConversionView;
  try {
    found = await server.conversion(document.path, node, form);
  } catch (error) {
    useRun.getState().setTrouble(error instanceof Error ? error.message : String(error));
    return;
  }
  const answer = await askChoice({
    title: `${view.name} as a ${WORDS[form]}`,
    label: "What to do",
    lead: leadOf(found),
    columns: [
      { title: `Now (${found.before.length} nodes)`, lines: found.before },
      { title: `Then (${found.after.length} nodes)`, lines: found.after },
    ],
    options: [
      { value: "yes", label: found.same ? "Convert" : "Convert all the same", detail: "One edit, which undo takes back to the byte" },
      { value: "no", label: "Leave it as it is" },
    ],
  });
  if (answer === "yes") await convert(node, form);
}

const WORDS: Record<Form, string> = { tree: "behaviour tree", machine: "state machine" };

async function askForm(name: string, kind: string): Promise<Form | null> {
  const options = [
    { value: "tree", label: "To a behaviour tree", detail: "State machines in it become sequences, fallbacks and loops, where they have a structure" },
    { value: "machine", label: "To a state machine", detail: "Sequences, fallbacks and loops in it become states and edges" },
  ];
  if (kind !== "state_machine") options.reverse();
  return (await askChoice({ title: `Convert ${name} (${KINDS[kind] ?? kind})`, label: "Form", options })) as Form | null;
}

function leadOf(found: ConversionView): string {
  const kept = found.kept.length > 0 ? ` Stays: ${found.kept.join("; ")}.` : "";
  if (found.same) return `Both forms are ${found.compared}.${kept}`;
  return `They are not the same. When ${found.script.join(", ")}: now ${found.does_before.join(", ")}; then ${found.does_after.join(", ")}.${kept}`;
}
