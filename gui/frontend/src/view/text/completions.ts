/** What may stand at the cursor: keys of the schema, nodes of the catalogue, names of the task. */
import type { Completion, CompletionContext, CompletionResult } from "@codemirror/autocomplete";
import { EditorSelection, StateEffect, StateField } from "@codemirror/state";
import { Decoration, type DecorationSet, EditorView } from "@codemirror/view";

import { nameOf } from "../../model/commands";
import { server } from "../../protocol/client";
import { kinds } from "../../model/kinds";
import { useDocument } from "../../store/document";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { namesFor, needNames, useNames } from "../../store/tasks";

const NODE_KEYS = ["node", "kind", "doc", "precondition", "on", "with", "in", "out", "meaning", "data", "outcomes", "exits", "children", "child"];
const TASK_KEYS = ["grip", "name", "doc", "outcomes", "data", "root"];

export function complete(context: CompletionContext): CompletionResult | null {
  const line = context.state.doc.lineAt(context.pos);
  const before = line.text.slice(0, context.pos - line.from);
  const word = /[A-Za-z_][\w/.-]*$/.exec(before)?.[0] ?? "";
  const lead = before.slice(0, before.length - word.length);
  if (word === "" && !context.explicit) return null;
  const options = optionsAfter(lead);
  return options.length > 0 ? { from: context.pos - word.length, options, validFor: /^[\w/.-]*$/ } : null;
}

function optionsAfter(lead: string): Completion[] {
  const { catalog } = useDocument.getState();
  if (/\bnode:\s*$/.test(lead)) return catalog.nodes.map((face) => ({ label: face.id, type: "function", detail: face.doc.split("\n")[0] ?? "" }));
  if (/\bkind:\s*$/.test(lead)) return kinds().map((face) => ({ label: face.kind, type: "class", detail: face.doc.split("\n")[0] ?? "" }));
  if (/\b(in|out):\s*\{[^}]*\w+:\s*$/.test(lead) || /\bitems:\s*$/.test(lead)) return variables();
  if (/\b(in|out|with):\s*\{([^}]*,\s*)?$/.test(lead)) return ports(lead);
  const given = parameterValues(lead);
  if (given) return given;
  if (/:\s*$/.test(lead)) return [...names(), ...variables()];
  if (/^\s*$/.test(lead)) return (lead === "" ? TASK_KEYS : keys()).map((label) => ({ label, type: "property", apply: `${label}: ` }));
  if (/[{,]\s*$/.test(lead)) return keys().map((label) => ({ label, type: "property", apply: `${label}: ` }));
  return [];
}

function keys(): string[] {
  const fields = kinds().flatMap((face) => face.fields.map((field) => field.key));
  return [...new Set([...NODE_KEYS, ...fields])];
}

function variables(): Completion[] {
  const seen = new Map(useRun.getState().task.variables.map((variable) => [variable.name, variable.type]));
  return [...seen].map(([label, detail]) => ({ label, type: "variable", detail }));
}

function names(): Completion[] {
  const { task } = useRun.getState();
  const nodes = task.nodes.filter((node) => node.path !== "/").map((node) => nameOf(node.path));
  const outcomes = task.nodes.flatMap((node) => Object.keys(node.outcomes));
  return [...new Set([...nodes, ...outcomes])].map((label) => ({ label, type: "constant" }));
}

/** What the project's files name, where the value of a parameter is written in the line of its node. */
function parameterValues(lead: string): Completion[] | null {
  const id = /\bnode:\s*([\w/]+)/.exec(lead)?.[1];
  const parameter = /\bwith:\s*\{(?:[^}]*,)?\s*(\w+):\s*$/.exec(lead)?.[1];
  if (id === undefined || parameter === undefined) return null;
  needNames();
  return namesFor(useNames.getState().places, id, parameter)?.map((label) => ({ label, type: "constant" })) ?? null;
}

/** Ports or parameters of the leaf that this line is about. */
function ports(lead: string): Completion[] {
  const id = /\bnode:\s*([\w/]+)/.exec(lead)?.[1];
  const face = useDocument.getState().catalog.nodes.find((each) => each.id === id);
  const side = /\b(in|out|with):\s*\{[^}]*$/.exec(lead)?.[1];
  const list = side === "with" ? face?.parameters : side === "in" ? face?.inputs : face?.outputs;
  return (list ?? []).map((port) => ({ label: port.name, type: "property", detail: port.type, info: port.doc, apply: `${port.name}: ` }));
}

const setMark = StateEffect.define<number | null>();
const MARK = Decoration.line({ class: "cm-node-line" });

export const markedLine = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update(marks, transaction) {
    let now = marks.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (effect.is(setMark)) now = effect.value === null ? Decoration.none : Decoration.set([MARK.range(effect.value)]);
    }
    return now;
  },
  provide: (field) => EditorView.decorations.from(field),
});

/** Keep the selections of an editor and the page together until the returned function is called. */
export function followSelection(view: EditorView, isDirty: () => boolean): () => void {
  let lines: Record<string, number> = {};
  let known = -1;
  let closed = false;

  async function load(): Promise<void> {
    const { document } = useDocument.getState();
    if (document === null || document.revision === known) return;
    known = document.revision;
    const places = await server.places(document.path).catch(() => null);
    if (closed || places === null || places.revision !== useDocument.getState().document?.revision) return;
    lines = places.lines;
    show(usePage.getState().selected, false);
  }

  function startOf(path: string | null): number | null {
    const number = path === null ? undefined : lines[path];
    return number === undefined || number > view.state.doc.lines ? null : view.state.doc.line(number).from;
  }

  function show(path: string | null, scroll: boolean): void {
    const from = startOf(path);
    if (from === null) return;
    view.dispatch({ effects: [setMark.of(from), ...(scroll ? [EditorView.scrollIntoView(from, { y: "center" })] : [])] });
  }

  /** Something beside the text or above it has come or gone: lines are wrapped elsewhere, and what is looked at stays in sight. */
  function keepInSight(): void {
    const at = view.hasFocus ? view.state.selection.main.head : startOf(usePage.getState().selected);
    if (at === null) return;
    const { from, to } = view.state.doc.lineAt(at);
    view.dispatch({ effects: EditorView.scrollIntoView(EditorSelection.range(to, from), { y: "nearest", yMargin: 20 }) });
  }

  function selectAtCursor(): void {
    if (isDirty() || !view.hasFocus) return;
    const line = view.state.doc.lineAt(view.state.selection.main.head).number;
    let best: string | null = null;
    for (const [path, at] of Object.entries(lines)) if (at <= line && (best === null || at >= (lines[best] as number))) best = path;
    if (best !== null && best !== usePage.getState().selected) usePage.getState().select(best);
  }

  view.dom.addEventListener("keyup", selectAtCursor);
  view.dom.addEventListener("mouseup", selectAtCursor);
  const size = (): string => `${view.dom.clientWidth} ${view.dom.clientHeight}`;
  let before = size();
  const sized = new ResizeObserver(() => {
    if (view.dom.clientWidth === 0 || size() === before) return;
    before = size();
    keepInSight();
  });
  sized.observe(view.dom);
  const stops = [
    () => sized.disconnect(),
    useDocument.subscribe(() => void load()),
    usePage.subscribe((now, before) => {
      if (now.selected !== before.selected) show(now.selected, !view.hasFocus);
    }),
  ];
  void load().then(() => !closed && show(usePage.getState().selected, true));
  return () => {
    closed = true;
    view.dom.removeEventListener("keyup", selectAtCursor);
    view.dom.removeEventListener("mouseup", selectAtCursor);
    for (const stop of stops) stop();
  };
}
