/** The file itself, beside its form: typed text is looked at as soon as the person pauses. */
import { autocompletion, type CompletionContext, completionKeymap, type CompletionResult } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { yaml } from "@codemirror/lang-yaml";
import { indentUnit } from "@codemirror/language";
import { lintGutter, setDiagnostics } from "@codemirror/lint";
import { EditorState, Transaction } from "@codemirror/state";
import { EditorView, keymap, lineNumbers } from "@codemirror/view";
import { type JSX, useEffect, useRef } from "react";
import { formKind, keyBefore, optionsAt, type Shape, shapeAt } from "../../model/shapes";
import { topicsAt } from "../../model/parts";
import { useLive } from "../../store/live";
import { typeSetup, useSetup } from "../../store/setup";
import { colours, theme } from "../text/theme";

const PAUSE = 300;

export function SetupText(): JSX.Element {
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!host.current) return;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const listener = EditorView.updateListener.of((update) => {
      if (!update.docChanged || update.transactions.some((each) => each.annotation(Transaction.remote))) return;
      clearTimeout(timer);
      timer = setTimeout(() => {
        timer = undefined;
        void typeSetup(update.state.sliceDoc());
      }, PAUSE);
    });
    const extensions = [
      lineNumbers(),
      history(),
      EditorView.lineWrapping,
      indentUnit.of("  "),
      yaml(),
      colours,
      theme,
      lintGutter(),
      autocompletion({ override: [complete] }),
      keymap.of([...completionKeymap, ...historyKeymap, ...defaultKeymap]),
      EditorView.contentAttributes.of({ "aria-label": "Text of the file", tabindex: "0" }),
      listener,
    ];
    const view = new EditorView({ parent: host.current, state: EditorState.create({ doc: useSetup.getState().view?.text ?? "", extensions }) });
    const stop = useSetup.subscribe((now, before) => {
      const text = now.view?.text ?? "";
      if (timer === undefined && text !== view.state.sliceDoc())
        view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: text }, annotations: Transaction.remote.of(true) });
      if (now.view?.problems !== before.view?.problems) squiggle(view);
      if (now.line !== before.line && now.line !== null && now.line <= view.state.doc.lines) {
        view.dispatch({ selection: { anchor: view.state.doc.line(now.line).from }, scrollIntoView: true });
        view.focus();
      }
    });
    squiggle(view);
    const { line } = useSetup.getState();
    if (line !== null && line <= view.state.doc.lines) {
      view.dispatch({ selection: { anchor: view.state.doc.line(line).from }, scrollIntoView: true });
      view.focus();
    }
    return () => {
      stop();
      if (timer !== undefined) void typeSetup(view.state.sliceDoc());
      clearTimeout(timer);
      view.destroy();
    };
  }, []);
  return <div className="text-host" ref={host} />;
}

function squiggle(view: EditorView): void {
  const { doc } = view.state;
  const problems = useSetup.getState().view?.problems ?? [];
  const found = problems.flatMap((problem) => {
    if (problem.line === null || problem.line > doc.lines) return [];
    const line = doc.line(problem.line);
    const from = Math.min(line.to, line.from + Math.max(0, (problem.column ?? 1) - 1));
    const word = /^[^,}#]*/.exec(doc.sliceString(from, line.to))?.[0].trimEnd().length ?? 0;
    return [{ from, to: Math.min(line.to, from + Math.max(1, word)), severity: problem.severity, message: problem.message }];
  });
  view.dispatch(setDiagnostics(view.state, found));
}

/** Keys of the shape, and what may stand behind a key. */
function complete(context: CompletionContext): CompletionResult | null {
  const { view } = useSetup.getState();
  const before = context.state.sliceDoc(0, context.pos);
  const word = /[\w/.-]*$/.exec(before)?.[0] ?? "";
  if (view === null || (word === "" && !context.explicit)) return null;
  const place = keyBefore(before.slice(0, before.length - word.length), before.length - word.length);
  const from = context.pos - word.length;
  const values = /:\s*$/.test(before.slice(0, from)) ? (topicsAt(useLive.getState().topics?.topics, place) ?? optionsAt(view.options, place)) : undefined;
  if (values) return { from, options: values.map((label) => ({ label, type: "constant" })), validFor: /^[\w/.-]*$/ };
  const root = view.shape as Shape;
  const exact = shapeAt(root, place);
  const keys = optionsAt(view.options, [...place, "?"]);
  if (keys) return { from, options: keys.map((label) => ({ label, type: "property", apply: `${label}: ` })), validFor: /^[\w/.-]*$/ };
  if (formKind(exact) !== "fields") return null;
  const options = Object.entries(exact.properties ?? {}).map(([label, inner]) => ({ label, type: "property", apply: `${label}: `, info: inner.description ?? "" }));
  return { from, options, validFor: /^\w*$/ };
}
