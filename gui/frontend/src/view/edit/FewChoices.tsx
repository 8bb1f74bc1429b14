/** A handful of choices: a button each. Arrows go from one to the next, letters to those that begin with them. */
import { type JSX, type KeyboardEvent, useRef } from "react";

import { startingWith, turned } from "../../model/choices";
import type { ChoiceQuestion } from "../../store/ask";

/** A choice that leaves all as it is; where there is one, nothing else has to say so. */
const NEITHER = "no";

interface Props {
  readonly question: ChoiceQuestion;
  readonly answer: (value: string | null) => void;
}

export function FewChoices({ question, answer }: Props): JSX.Element {
  const list = useRef<HTMLDivElement>(null);

  function onKeyDown(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const buttons = [...(list.current?.querySelectorAll("button") ?? [])];
    const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
    const to = turned(event.key, at, buttons.length) ?? startingWith(question.options, event.key, at);
    if (to === null) return;
    event.preventDefault();
    buttons[to]?.focus();
  }

  return (
    <div className="few-choices">
      <p id="few-choices-label" className="hint">
        {question.label}
      </p>
      <div role="group" aria-labelledby="few-choices-label" ref={list} onKeyDown={onKeyDown}>
        {question.options.map((option) => (
          <button key={option.value} type="button" onClick={() => answer(option.value)}>
            <span className="option-label">{option.label}</span> {option.mark && <span className="option-mark">{option.mark}</span>}{" "}
            {option.detail && <span className="option-detail">{option.detail}</span>}
          </button>
        ))}
      </div>
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
