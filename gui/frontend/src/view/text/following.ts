/** One selection for drawings and text: the cursor selects the node that it is in, and a selected node's line is shown. */
import { StateEffect, StateField } from "@codemirror/state";
import { Decoration, type DecorationSet, EditorView } from "@codemirror/view";

import { server } from "../../protocol/client";
import { useDocument } from "../../store/document";
import { usePage } from "../../store/page";

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

  function show(path: string | null, scroll: boolean): void {
    const number = path === null ? undefined : lines[path];
    if (number === undefined || number > view.state.doc.lines) return;
    const { from } = view.state.doc.line(number);
    view.dispatch({ effects: [setMark.of(from), ...(scroll ? [EditorView.scrollIntoView(from, { y: "center" })] : [])] });
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
  const stops = [
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
