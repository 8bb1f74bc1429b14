/** Fields of forms: each sends its edit when it is left or Enter is pressed, and Escape takes back what was typed. */
import { type JSX, type ReactNode, useEffect, useId, useRef, useState } from "react";

import { parseValue, valueText } from "../../model/values";
import { server } from "../../protocol/client";
import { useDocument } from "../../store/document";

interface FieldProps {
  readonly label: string;
  readonly doc?: string;
  readonly children: (id: string, describedBy: string) => ReactNode;
  readonly fault?: string;
  readonly mark?: string;
}

/** What docs say, with names that stand between backticks as such. */
export function Prose({ text }: { text: string }): JSX.Element {
  return <>{text.split("`").map((part, at) => (at % 2 === 1 ? <code key={at}>{part}</code> : part))}</>;
}

export function Field({ label, doc, children, fault, mark }: FieldProps): JSX.Element {
  const id = useId();
  return (
    <div className="form-field">
      <label htmlFor={id}>
        {label} {mark && <code>{mark}</code>}
      </label>
      {children(id, `${id}-about`)}
      <p id={`${id}-about`} className={fault ? "fault" : "hint"}>
        {fault || (doc && <Prose text={doc} />)}
      </p>
    </div>
  );
}

interface TextProps {
  readonly label: string;
  readonly value: unknown;
  readonly type: string;
  readonly doc?: string;
  readonly placeholder?: string;
  readonly disabled: boolean;
  readonly lines?: number;
  /** What may stand there, among other things. */
  readonly options?: readonly string[] | undefined;
  /** Called with a value, or with undefined for an empty field. */
  readonly set: (value: unknown) => void;
  /** Problems with a text while it is typed. */
  readonly check?: (text: string) => Promise<string>;
}

/** A literal. An empty field means the default. */
export function ValueField({ label, value, type, doc, placeholder, disabled, lines, options, set, check }: TextProps): JSX.Element {
  const given = valueText(value, type);
  const [text, setText] = useState(given);
  const [fault, setFault] = useState("");
  /** What it was when the person began to type. */
  const [base, setBase] = useState(given);
  const sent = useRef<{ readonly typed: string; readonly value: string } | null>(null);
  useEffect(() => {
    const own = sent.current;
    sent.current = null;
    if (own?.value === given ? text !== own.typed : text !== base && text !== given) {
      // Typed on since: it stays, on what is there now.
      if (own?.value === given) return setBase(given);
      return setFault(`Somebody set this to ${given === "" ? "its default" : given} meanwhile. Enter puts yours there, Escape takes theirs.`);
    }
    setText(given);
    setBase(given);
    setFault("");
    // What is typed is compared when something else comes, not at each letter.
  }, [given]);
  useEffect(() => {
    if (!check || text === given || text === "") return;
    let late = false;
    const timer = setTimeout(() => void check(text).then((found) => late || setFault(found)), 250);
    return () => {
      late = true;
      clearTimeout(timer);
    };
  }, [text, given, check]);
  const commit = (over: boolean): void => {
    // Who leaves the field hasn't decided against what another has put there.
    if (text === given || (base !== given && !over)) return;
    const parsed = text === "" ? { value: undefined } : parseValue(text, type);
    if ("fault" in parsed) return setFault(parsed.fault);
    sent.current = { typed: text, value: parsed.value === undefined ? "" : valueText(parsed.value, type) };
    setBase(given);
    setFault("");
    set(parsed.value);
  };
  return (
    <Field label={label} {...(doc ? { doc } : {})} fault={fault} {...(type === "text" || type === "expression" ? {} : { mark: type })}>
      {(id, about) => {
        const common = {
          id,
          value: text,
          disabled,
          placeholder,
          "aria-describedby": about,
          "aria-invalid": fault !== "",
          spellCheck: type === "text",
          onBlur: () => commit(false),
          onChange: (event: { target: { value: string } }) => setText(event.target.value),
        };
        const keys = (event: { key: string; preventDefault: () => void }): void => {
          if (event.key === "Enter" && !lines) commit(true);
          if (event.key !== "Escape") return;
          setText(given);
          setBase(given);
          setFault("");
        };
        if (lines) return <textarea rows={lines} {...common} onKeyDown={keys} />;
        return (
          <>
            <input type="text" {...common} {...(options ? { list: `${id}-known` } : {})} onKeyDown={keys} />
            {options && (
              <datalist id={`${id}-known`}>
                {options.map((option) => (
                  <option key={option} value={option} />
                ))}
              </datalist>
            )}
          </>
        );
      }}
    </Field>
  );
}

interface ChoiceProps {
  readonly label: string;
  readonly value: string;
  readonly options: readonly (readonly [value: string, label: string])[];
  readonly doc?: string;
  readonly mark?: string;
  readonly disabled: boolean;
  readonly set: (value: string) => void;
}

export function ChoiceField({ label, value, options, doc, mark, disabled, set }: ChoiceProps): JSX.Element {
  const known = options.some(([each]) => each === value);
  return (
    <Field label={label} {...(doc ? { doc } : {})} {...(mark ? { mark } : {})}>
      {(id, about) => (
        <select id={id} value={value} disabled={disabled} aria-describedby={about} onChange={(event) => set(event.target.value)}>
          {!known && <option value={value}>{value}</option>}
          {options.map(([each, words]) => (
            <option key={each} value={each}>
              {words}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

/** Ask the server what is wrong with an expression at a key of a node. */
export function expressionCheck(node: string, key: string): (text: string) => Promise<string> {
  return async (text) => {
    const path = useDocument.getState().document?.path;
    if (path === undefined) return "";
    const faults = await server.expression({ path, node, key: [key], text }).catch(() => [] as string[]);
    return faults[0] ?? "";
  };
}
