/** The rules of a parallel, a block each: which children have ended how, how many, and what then. The first that holds decides. */
import type { JSX } from "react";

import { join, nameOf } from "../../model/commands";
import { counting, labelsOf, type Rule, rulesOf, shifted, withLabels } from "../../model/rows";
import type { NodeView } from "../../protocol/generated";
import { edit, settingNow } from "../../store/editing";
import { useRun } from "../../store/run";
import { ChoiceField, ValueField } from "./fields";
import { RowTools } from "./RowTools";
import { Tick } from "./Tick";

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
