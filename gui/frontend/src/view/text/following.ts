/** One selection for drawings and text: the cursor selects the node that it is in, and a selected node's line is shown. */
import { EditorSelection, StateEffect, StateField } from "@codemirror/state";
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
