/** The dialog of the question that is open: a text, a few buttons, or a choice from a list that is filtered while typing. */
import { type JSX, type KeyboardEvent, lazy, Suspense, useEffect, useId, useMemo, useRef, useState } from "react";
import { matching } from "../../model/commands";
import { turned } from "../../model/values";
import { Prose } from "./fields";
import { type ChoiceQuestion, type FileQuestion, isFew, type TextQuestion, useAsk } from "../../store/ask";

const FileBrowser = lazy(() => import("../start/FileBrowser"));

/** Most options that are listed; typing finds the others. */
const SHOWN = 200;

export function Ask(): JSX.Element | null {
  const question = useAsk((s) => s.question);
  const answer = useAsk((s) => s.answer);
  const dialog = useRef<HTMLDialogElement>(null);
  const title = useId();
  useEffect(() => {
    if (!question) return;
    const before = document.activeElement;
    if (!dialog.current?.open) dialog.current?.showModal();
    dialog.current?.querySelector<HTMLElement>("input, [role=group] button")?.focus();
    return () => {
      if (before instanceof HTMLElement && before.isConnected) before.focus();
    };
  }, [question]);
  if (!question) return null;
  return (
    <dialog ref={dialog} className="ask" aria-labelledby={title} onClose={() => answer(null)} onClick={(event) => {
        if (event.target === dialog.current) answer(null);
      }}
    >
      <h2 id={title}>{question.title}</h2>
      {question.kind === "text" && <TextForm key={question.title} question={question} answer={answer} />}
      {question.kind === "choice" && <Choice key={question.title} question={question} answer={answer} />}
      {question.kind === "file" && <Browse question={question} answer={answer} />}
    </dialog>
  );
}

function TextForm({ question, answer }: { question: TextQuestion; answer: (text: string | null) => void }): JSX.Element {
  const [text, setText] = useState(question.initial);
  const fault = text === question.initial ? "" : (question.check?.(text) ?? "");
  const id = useId();
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.select(), []);
  return (
    <form
      method="dialog"
      onSubmit={(event) => {
        event.preventDefault();
        if (!fault && text !== "") answer(text);
      }}
    >
      <label htmlFor={id}>{question.label}</label>
      <input id={id} ref={field} value={text} aria-invalid={fault !== ""} aria-describedby={`${id}-hint`} onChange={(event) => setText(event.target.value)} />
      <p id={`${id}-hint`} className={fault ? "fault" : "hint"}>
        {fault || question.hint}
      </p>
      <div className="ask-buttons">
        <button type="button" onClick={() => answer(null)}>
          Cancel
        </button>
        <button type="submit" className="main" disabled={fault !== "" || text === ""}>
          OK
        </button>
      </div>
    </form>
  );
}

function Browse({ question, answer }: { question: FileQuestion; answer: (path: string | null) => void }): JSX.Element {
  return (
    <>
      <Suspense fallback={<p className="hint" role="status">Looking ...</p>}>
        <FileBrowser fits={question.fits} chosen="" choose={answer} />
      </Suspense>
      <div className="ask-buttons">
        <button type="button" onClick={() => answer(null)}>
          Cancel
        </button>
      </div>
    </>
  );
}

function Choice({ question, answer }: { question: ChoiceQuestion; answer: (value: string | null) => void }): JSX.Element {
  return (
    <>
      {question.lead && <p>{question.lead}</p>}
      {question.columns && (
        <div className="ask-columns">
          {question.columns.map((column) => (
            <figure key={column.title}>
              <figcaption>{column.title}</figcaption>
              <pre tabIndex={0} aria-label={column.title}>
                {column.lines.join("\n")}
              </pre>
            </figure>
          ))}
        </div>
      )}
      {isFew(question) ? <FewChoices question={question} answer={answer} /> : <Chooser question={question} answer={answer} />}
    </>
  );
}

function Chooser({ question, answer }: { question: ChoiceQuestion; answer: (value: string | null) => void }): JSX.Element {
  const [text, setText] = useState("");
  const [at, setAt] = useState(0);
  const id = useId();
  const list = useRef<HTMLUListElement>(null);
  const found = useMemo(() => matching(question.options, text), [question, text]);
  const shown = found.slice(0, SHOWN);
  const active = Math.min(at, shown.length - 1);
  useEffect(() => {
    list.current?.children[active]?.scrollIntoView({ block: "nearest" });
  }, [active]);

  function onKeyDown(event: KeyboardEvent): void {
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8 }[event.key];
    if (by !== undefined) {
      event.preventDefault();
      setAt(Math.max(0, Math.min(shown.length - 1, active + by)));
    } else if (event.key === "Enter" && !event.nativeEvent.isComposing) {
      event.preventDefault();
      const chosen = shown[active];
      // Where nothing is found there is nothing to take, and the question stays.
      if (chosen !== undefined) answer(chosen.value);
    }
  }

  return (
    <div className="chooser">
      <label htmlFor={id}>{question.label}</label>
      <input
        id={id}
        role="combobox"
        aria-expanded="true"
        aria-controls={`${id}-list`}
        aria-autocomplete="list"
        {...(shown[active] ? { "aria-activedescendant": `${id}-${active}` } : {})}
        autoComplete="off"
        value={text}
        onKeyDown={onKeyDown}
        onChange={(event) => {
          setText(event.target.value);
          setAt(0);
        }}
      />
      <ul id={`${id}-list`} role="listbox" aria-label={question.label} ref={list}>
        {shown.map((option, i) => (
          <li key={option.value} id={`${id}-${i}`} role="option" aria-selected={i === active} onClick={() => answer(option.value)} onPointerMove={() => setAt(i)}>
            <span className="option-label">{option.label}</span>
            {option.mark && <span className="option-mark">{option.mark}</span>}
            {option.detail && <span className="option-detail"><Prose text={option.detail} /></span>}
          </li>
        ))}
      </ul>
      <p className="hint" role="status">
        {found.length === 0 ? "Nothing is like this." : found.length > SHOWN ? `${SHOWN} of ${found.length} are shown; type to find others.` : `${found.length} ${found.length === 1 ? "entry" : "entries"}`}
      </p>
    </div>
  );
}

/** A choice that leaves all as it is; where there is one, nothing else has to say so. */
const NEITHER = "no";

interface Props {
  readonly question: ChoiceQuestion;
  readonly answer: (value: string | null) => void;
}

/** Buttons: letters leave those that they mean, arrows go round, Enter takes the one that has the focus. */
export function FewChoices({ question, answer }: Props): JSX.Element {
  const list = useRef<HTMLDivElement>(null);
  const [text, setText] = useState("");
  const found = useMemo(() => matching(question.options, text), [question, text]);
  useEffect(() => {
    const buttons = [...(list.current?.querySelectorAll("button") ?? [])];
    const first = buttons.find((button) => button.value === found[0]?.value);
    if (text !== "") (first ?? list.current)?.focus();
  }, [text, found]);

  function onKeyDown(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.nativeEvent.isComposing) return;
    const buttons = [...(list.current?.querySelectorAll<HTMLButtonElement>("button:not([hidden])") ?? [])];
    const to = turned(event.key, buttons.indexOf(document.activeElement as HTMLButtonElement), buttons.length);
    const typed = event.key.length === 1 && (event.key !== " " || text !== "");
    if (to === null && !typed && event.key !== "Backspace") return;
    event.preventDefault();
    if (to !== null) buttons[to]?.focus();
    else setText(typed ? text + event.key : text.slice(0, -1));
  }

  return (
    <div className="few-choices" onKeyDown={onKeyDown}>
      <p id="few-choices-label" className="hint">
        {question.label}
      </p>
      <div role="group" aria-labelledby="few-choices-label" ref={list} tabIndex={-1}>
        {question.options.map((option) => (
          <button key={option.value} type="button" value={option.value} hidden={!found.some((each) => each.value === option.value)} onClick={() => answer(option.value)}>
            <span className="option-label">{option.label}</span> {option.mark && <span className="option-mark">{option.mark}</span>}{" "}
            {option.detail && <span className="option-detail"><Prose text={option.detail} /></span>}
          </button>
        ))}
      </div>
      <p className="hint typed" role="status">
        {text === "" ? "" : found.length === 0 ? `Nothing is like "${text}"; Backspace takes letters back.` : `"${text}": ${found.length} of ${question.options.length}`}
      </p>
      {!question.options.some((option) => option.value === NEITHER) && (
        <div className="ask-buttons">
          <button type="button" onClick={() => answer(null)}>
            Cancel
          </button>
        </div>
      )}
    </div>
  );
}
