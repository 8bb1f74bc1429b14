/** The rules of a parallel, a block each: which children have ended how, how many, and what then. The first that holds decides. */
import { type JSX, useEffect, useRef, useState } from "react";

import { join, nameOf } from "../../model/commands";
import { counting, labelsOf, literalsText, parseLiterals, type Rule, rulesOf, shifted, type Wait, waitOf, withLabels } from "../../model/rows";
import type { SettingView, NodeView } from "../../protocol/generated";
import { askChoice } from "../../store/ask";
import { edit, settingNow } from "../../store/editing";
import { useRun } from "../../store/run";
import { ChoiceField, Field, ValueField } from "./fields";

export function RulesForm({ node, locked }: { node: NodeView; locked: boolean }): JSX.Element {
  const rules = rulesOf(node.fields["rules"]);
  const set = (change: (rules: readonly Rule[]) => readonly Rule[]): Promise<boolean> =>
    edit(() => {
      const next = change(rulesOf(settingNow(node.path, "rules")));
      return next.length > 0 ? { do: "set", path: node.path, key: ["rules"], value: next } : { do: "unset", path: node.path, key: ["rules"] };
    });
  const put = (at: number, change: (rule: Rule) => Rule): Promise<boolean> => set((now) => now.map((old, i) => (i === at ? change(old) : old)));
  const outcomes = Object.keys(node.outcomes);
  return (
    <section className="rows" aria-label="Rules">
      <h3>Rules</h3>
      <p className="hint">The first rule whose conditions all hold decides; one without conditions is for the rest, when all have ended.</p>
      {rules.map((rule, at) => (
        <fieldset key={at} disabled={locked}>
          <legend>Rule {at + 1}</legend>
          <RowTools about={`rule ${at + 1}`} first={at === 0} last={at === rules.length - 1} shift={(by) => void set((now) => shifted(now, at, by))} remove={() => void set((now) => now.filter((_, i) => i !== at))} />
          {node.children.map((child) => (
            <ChildEnds key={child} child={nameOf(child)} container={node} rule={rule} set={(change) => put(at, change)} />
          ))}
          <div className="pair">
            <ValueField label="At least" type="int" value={rule.at_least} placeholder="any number" disabled={locked} set={(least) => void put(at, (now) => counting(now, least === undefined ? null : Number(least), now.ends ?? "success"))} />
            <ChoiceField label="end with" value={rule.ends ?? "success"} options={[["success", "success"], ["failure", "failure"]]} disabled={locked || rule.at_least === undefined} set={(ends) => void put(at, (now) => counting(now, now.at_least ?? null, ends as "success" | "failure"))} />
          </div>
          <ChoiceField label="Then it ends with" value={rule.then} options={outcomes.map((each): [string, string] => [each, each])} disabled={locked} set={(then) => void put(at, (now) => ({ ...now, then }))} />
        </fieldset>
      ))}
      {!locked && <button onClick={() => void set((now) => [...now, { then: outcomes[0] ?? "success" }])}>New rule</button>}
    </section>
  );
}

interface EndsProps {
  readonly child: string;
  readonly container: NodeView;
  readonly rule: Rule;
  readonly set: (change: (rule: Rule) => Rule) => Promise<unknown>;
}

function ticked(labels: readonly string[], label: string, on: boolean): string[] {
  const others = labels.filter((each) => each !== label);
  return on ? [...others, label] : others;
}

/** With which of its outcomes a child has to have ended; none of them: the rule doesn't look at it. */
function ChildEnds({ child, container, rule, set }: EndsProps): JSX.Element {
  const view = useRun((s) => s.index.byPath.get(join(container.path, child)));
  const given = labelsOf(rule, child);
  const labels = [...new Set([...Object.keys(view?.outcomes ?? {}), ...given])];
  return (
    <div role="group" aria-label={`${child} has ended with`} className="ends">
      <span>{child}</span>
      {labels.map((label) => (
        <Tick key={label} label={label} checked={given.includes(label)} set={(on) => set((now) => withLabels(now, child, ticked(labelsOf(now, child), label, on)))} />
      ))}
    </div>
  );
}

export function CasesForm({ node, locked }: { node: NodeView; locked: boolean }): JSX.Element {
  const entries = (value: unknown): [string, unknown][] => Object.entries((value ?? {}) as Record<string, unknown>);
  const cases = entries(node.fields["cases"]);
  const shift = (at: number, by: -1 | 1): void =>
    void edit(() => ({ do: "set", path: node.path, key: ["cases"], value: Object.fromEntries(shifted(entries(settingNow(node.path, "cases")), at, by)) }));
  const without = node.children.map(nameOf).filter((name) => !cases.some(([child]) => child === name));
  return (
    <section className="rows" aria-label="Cases">
      <h3>Cases</h3>
      {cases.map(([child, said], at) => (
        <div key={child} className="field-row">
          <CaseField child={child} said={said} locked={locked} set={(value) => void edit({ do: "set", path: node.path, key: ["cases", child], value })} />
          {!locked && (
            <RowTools
              about={`the case of ${child}`}
              first={at === 0}
              last={at === cases.length - 1}
              shift={(by) => shift(at, by)}
              remove={() => void edit({ do: "unset", path: node.path, key: ["cases", child] })}
            />
          )}
        </div>
      ))}
      {!locked && without.length > 0 && (
        <button onClick={() => void newCase(node, without)}>New case</button>
      )}
    </section>
  );
}

async function newCase(node: NodeView, without: readonly string[]): Promise<void> {
  const child = without.length === 1 ? without[0] : await askChoice({ title: "New case", label: "Which child is taken?", options: without.map((name) => ({ value: name, label: name })) });
  // The name of the child is a literal that no other case has.
  if (child) await edit({ do: "set", path: node.path, key: ["cases", child], value: child });
}

interface CaseProps {
  readonly child: string;
  readonly said: unknown;
  readonly locked: boolean;
  readonly set: (value: unknown) => void;
}

function CaseField({ child, said, locked, set }: CaseProps): JSX.Element {
  const given = literalsText(said);
  const [text, setText] = useState(given);
  const [fault, setFault] = useState("");
  useEffect(() => {
    setText(given);
    setFault("");
  }, [given]);
  const commit = (): void => {
    if (text === given) return;
    const parsed = parseLiterals(text);
    if ("fault" in parsed) setFault(parsed.fault);
    else set(parsed.value);
  };
  return (
    <Field label={`${child} is taken for`} fault={fault}>
      {(id, about) => (
        <input
          id={id}
          type="text"
          value={text}
          disabled={locked}
          aria-describedby={about}
          aria-invalid={fault !== ""}
          onChange={(event) => setText(event.target.value)}
          onBlur={commit}
          onKeyDown={(event) => {
            if (event.key === "Enter") commit();
            if (event.key === "Escape") setText(given);
          }}
        />
      )}
    </Field>
  );
}

interface RowToolsProps {
  readonly about: string;
  readonly first: boolean;
  readonly last: boolean;
  readonly shift: (by: -1 | 1) => void;
  readonly remove: () => void;
}

export function RowTools({ about, first, last, shift, remove }: RowToolsProps): JSX.Element {
  return (
    <span className="row-tools">
      <button aria-label={`Move ${about} up`} title="Up" disabled={first} onClick={() => shift(-1)}>
        ↑
      </button>
      <button aria-label={`Move ${about} down`} title="Down" disabled={last} onClick={() => shift(1)}>
        ↓
      </button>
      <button aria-label={`Remove ${about}`} title="Remove" onClick={remove}>
        ×
      </button>
    </span>
  );
}

const WAITS: readonly (readonly [Wait, string])[] = [
  ["", "nobody: as soon as it is decided"],
  ["all", "all children"],
  ["any", "one child"],
  ["count", "so many children"],
  ["these", "these children"],
];

function waitedFor(value: unknown): readonly string[] {
  return Array.isArray(value) ? (value as string[]) : [];
}

export function WaitForm({ field, node, locked }: { field: SettingView; node: NodeView; locked: boolean }): JSX.Element {
  const value = node.fields["wait_for"];
  const children = node.children.map(nameOf);
  const wait = waitOf(value);
  const set = (next: unknown): Promise<boolean> =>
    edit(next === undefined ? { do: "unset", path: node.path, key: ["wait_for"] } : { do: "set", path: node.path, key: ["wait_for"], value: next });
  const choose = (word: string): void => void set({ "": undefined, all: "all", any: "any", count: Math.max(1, children.length - 1), these: children }[word as Wait]);
  const these = waitedFor(value);
  return (
    <>
      <ChoiceField label="Waits for" doc={field.doc} value={wait} options={WAITS} disabled={locked} set={choose} />
      {wait === "count" && <ValueField label="How many children" type="int" value={value} disabled={locked} set={(many) => void set(many)} />}
      {wait === "these" && (
        <div role="group" aria-label="Children that are waited for" className="ends">
          {children.map((name) => (
            <Tick
              key={name}
              label={name}
              disabled={locked || (these.length === 1 && these[0] === name)}
              checked={these.includes(name)}
              set={(on) => edit(() => ({ do: "set", path: node.path, key: ["wait_for"], value: children.filter((each) => (each === name ? on : waitedFor(settingNow(node.path, "wait_for")).includes(each))) }))}
            />
          ))}
        </div>
      )}
    </>
  );
}

interface TickProps {
  readonly label: string;
  readonly checked: boolean;
  readonly disabled?: boolean;
  readonly set: (checked: boolean) => Promise<unknown>;
}

export function Tick({ label, checked, disabled = false, set }: TickProps): JSX.Element {
  const [shown, setShown] = useState(checked);
  const now = useRef(checked);
  useEffect(() => {
    now.current = checked;
    setShown(checked);
  }, [checked]);
  const change = async (wished: boolean): Promise<void> => {
    setShown(wished);
    await set(wished);
    setShown(now.current);
  };
  return (
    <label className="check">
      <input type="checkbox" checked={shown} disabled={disabled} onChange={(event) => void change(event.target.checked)} />
      {label}
    </label>
  );
}
