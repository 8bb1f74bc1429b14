/** The task's file as text: typed text goes to the server as an edit, and stays here whether it is a task or not. */
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap } from "@codemirror/commands";
import { yaml } from "@codemirror/lang-yaml";
import { foldGutter, indentUnit } from "@codemirror/language";
import { type Diagnostic, lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";

import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { Compartment, EditorState, type Extension, Transaction } from "@codemirror/state";
import { EditorView, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import { type JSX, useEffect, useRef } from "react";

import type { Problem } from "../../protocol/generated";
import { useDocument } from "../../store/document";
import { redo, typeText, typing, undo } from "../../store/editing";
import { useRun } from "../../store/run";
import { complete, followSelection, markedLine } from "./completions";
import { colours, theme } from "./theme";

/** How long nothing must be typed until the text is sent [ms]. */
const PAUSE = 350;

export default function TextPane(): JSX.Element {
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!host.current) return;
    const pane = new Pane(host.current);
    return () => pane.close();
  }, []);
  const draft = useDocument((s) => s.document?.draft);
  return (
    <section className="text-pane" aria-label="Text">
      {draft && (
        <p className="stale-note" role="status">
          This text isn't a task yet. It is kept, also when it is saved; the drawings show the last task that it was.
        </p>
      )}
      <div className="text-host" ref={host} />
    </section>
  );
}

/** What was typed and couldn't be sent, by file; a reload keeps it. */
const unsent = {
  keep: (path: string, text: string): void => sessionStorage.setItem(`grip-typed:${path}`, text),
  take: (path: string): string | null => {
    const text = sessionStorage.getItem(`grip-typed:${path}`);
    sessionStorage.removeItem(`grip-typed:${path}`);
    return text;
  },
};

/** The editor, kept equal to the document wherever the person hasn't typed something that is still to be sent. */
class Pane {
  private readonly view: EditorView;
  private readonly lock = new Compartment();
  private readonly stop: (() => void)[] = [];
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** The revision whose text was here before the person typed. */
  private base: number;
  private sending = false;

  constructor(parent: HTMLElement) {
    const { document } = useDocument.getState();
    this.base = document?.revision ?? 0;
    const kept = document === null ? null : unsent.take(document.path);
    this.view = new EditorView({ parent, state: EditorState.create({ doc: kept ?? document?.text ?? "", extensions: this.extensions() }) });
    if (kept !== null) this.timer = setTimeout(() => void this.send(), PAUSE);
    this.stop.push(useDocument.subscribe((now, before) => this.heard(now.resets !== before.resets)));
    this.stop.push(useRun.subscribe((now, before) => now.task.problems !== before.task.problems && this.squiggle()));
    this.stop.push(useRun.subscribe((now, before) => now.record !== before.record && this.setLock()));
    this.stop.push(followSelection(this.view, () => this.dirty()));
    typing(() => this.send());
    this.squiggle();
    this.setLock();
  }

  close(): void {
    typing(null);
    const path = useDocument.getState().document?.path;
    if (this.dirty() && path !== undefined && useRun.getState().connected === false) unsent.keep(path, this.text());
    else if (this.dirty()) void this.send();
    clearTimeout(this.timer);
    for (const stop of this.stop) stop();
    this.view.destroy();
  }

  private extensions(): Extension[] {
    const step = (what: () => Promise<boolean>) => (): boolean => {
      void this.send().then(what);
      return true;
    };
    return [
      lineNumbers(),
      foldGutter(),
      highlightActiveLine(),
      highlightSelectionMatches(),
      closeBrackets(),
      EditorView.lineWrapping,
      indentUnit.of("  "),
      yaml(),
      colours,
      theme,
      lintGutter(),
      markedLine,
      autocompletion({ override: [complete] }),
      keymap.of([
        { key: "Mod-z", run: step(undo), preventDefault: true },
        { key: "Mod-Shift-z", run: step(redo), preventDefault: true },
        { key: "Mod-y", run: step(redo), preventDefault: true },
        ...closeBracketsKeymap,
        ...completionKeymap,
        ...lintKeymap,
        ...searchKeymap,
        ...defaultKeymap,
      ]),
      EditorView.contentAttributes.of({ "aria-label": "Text of the task", tabindex: "0" }),
      this.lock.of([]),
      EditorView.updateListener.of((update) => {
        if (!update.docChanged || update.transactions.every((t) => t.annotation(Transaction.remote))) return;
        clearTimeout(this.timer);
        this.timer = setTimeout(() => void this.send(), PAUSE);
      }),
    ];
  }

  private setLock(): void {
    const locked = useRun.getState().record !== null;
    this.view.dispatch({ effects: this.lock.reconfigure([EditorState.readOnly.of(locked), EditorView.editable.of(!locked)]) });
  }

  private text(): string {
    return this.view.state.sliceDoc();
  }

  /** Whether something was typed that the document doesn't have. */
  private dirty(): boolean {
    return this.timer !== undefined;
  }

  private async send(): Promise<boolean> {
    if (!this.dirty() || this.sending) return true;
    clearTimeout(this.timer);
    const text = this.text();
    this.sending = true;
    const taken = await typeText(text, this.base);
    this.sending = false;
    if (taken && this.text() === text) {
      this.timer = undefined;
      this.heard(false);
    } else if (taken) {
      this.base = useDocument.getState().document?.revision ?? this.base;
      this.timer = setTimeout(() => void this.send(), PAUSE);
    }
    return taken;
  }

  /** Take the document's text, unless something typed is still to be sent. */
  private heard(reset: boolean): void {
    const { document, conflict } = useDocument.getState();
    if (document === null || this.sending) return;
    if (reset || (this.dirty() && conflict === null && document.text === this.text())) {
      clearTimeout(this.timer);
      this.timer = undefined;
    }
    if (this.dirty()) return;
    this.base = document.revision;
    const now = this.text();
    if (now === document.text) return;
    this.view.dispatch({ changes: difference(now, document.text), annotations: Transaction.remote.of(true) });
    this.squiggle();
  }

  private squiggle(): void {
    const { problems } = useRun.getState().task;
    const found = problems.map((problem) => this.diagnostic(problem)).filter((each) => each !== null);
    this.view.dispatch(setDiagnostics(this.view.state, found));
  }

  private diagnostic(problem: Problem): Diagnostic | null {
    const { doc } = this.view.state;
    if (problem.line === null || problem.line > doc.lines) return null;
    const line = doc.line(problem.line);
    const from = Math.min(line.to, line.from + Math.max(0, (problem.column ?? 1) - 1));
    const word = /^[\w/. -]+/.exec(doc.sliceString(from, line.to))?.[0].trimEnd().length ?? 0;
    return { from, to: Math.min(line.to, from + Math.max(1, word)), severity: problem.severity, message: [problem.message, problem.fix].filter(Boolean).join(". "), source: problem.code };
  }
}

/** The one piece in which two texts differ, so that the cursor stays where it is. */
function difference(old: string, now: string): { from: number; to: number; insert: string } {
  const shorter = Math.min(old.length, now.length);
  let from = 0;
  while (from < shorter && old[from] === now[from]) from++;
  let end = 0;
  while (end < shorter - from && old[old.length - 1 - end] === now[now.length - 1 - end]) end++;
  return { from, to: old.length - end, insert: now.slice(from, now.length - end) };
}
