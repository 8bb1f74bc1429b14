/** Settings of a container, made from what the server says about its kind. */
import type { JSX } from "react";

import { nameOf, visibleVariables } from "../../model/commands";
import { kindOf } from "../../model/kinds";
import type { SettingView, NodeView } from "../../protocol/generated";
import { edit } from "../../store/editing";
import { useRun } from "../../store/run";
import { CasesForm, RulesForm, WaitForm } from "./RulesForm";
import { VariablesForm } from "./TaskForm";
import { ChoiceField, expressionCheck, Prose, ValueField } from "./fields";

export function ContainerForm({ node, locked }: { node: NodeView; locked: boolean }): JSX.Element {
  const face = kindOf(node.kind);
  return (
    <>
      {face && (
        <p className="hint">
          <Prose text={face.doc.split("\n\n")[0] ?? ""} />
        </p>
      )}
      {face?.fields.map((field) => {
        const Rows = ROWS[field.key];
        return Rows ? <Rows key={field.key} field={field} node={node} locked={locked} /> : <Setting key={field.key} field={field} node={node} locked={locked} />;
      })}
      {face?.declares && <VariablesForm scope={node.path} locked={locked} />}
    </>
  );
}

/** The settings of a container that take a line each and that somebody has set, or must. */
export function briefSettings(node: NodeView): readonly SettingView[] {
  const fields = kindOf(node.kind)?.fields ?? [];
  return fields.filter((field) => ROWS[field.key] === undefined && (field.required || node.fields[field.key] !== undefined));
}

/** Settings without what they mean. */
export function BriefSettings({ node, fields, locked }: { node: NodeView; fields: readonly SettingView[]; locked: boolean }): JSX.Element {
  return (
    <>
      {fields.map((field) => (
        <Setting key={field.key} field={field} node={node} locked={locked} brief />
      ))}
    </>
  );
}

interface SettingProps {
  readonly brief?: boolean;
  readonly field: SettingView;
  readonly node: NodeView;
  readonly locked: boolean;
}

/** Settings that are lists, as rows. */
const ROWS: Readonly<Record<string, (props: SettingProps) => JSX.Element>> = { rules: RulesForm, cases: CasesForm, wait_for: WaitForm };

function Setting({ field, node, locked, brief = false }: SettingProps): JSX.Element {
  const task = useRun((s) => s.task);
  const given = node.fields[field.key];
  const set = (value: unknown): void =>
    void edit(value === undefined || value === "" ? { do: "unset", path: node.path, key: [field.key] } : { do: "set", path: node.path, key: [field.key], value });
  const common = { label: LABELS[field.key] ?? field.key, doc: brief ? "" : field.doc || DOCS[field.key] || "", disabled: locked };
  if (field.type === "bool") {
    const value = String(given ?? field.default ?? false);
    return <ChoiceField {...common} value={value} options={[["true", "yes"], ["false", "no"]]} set={(word) => set(word === "true")} />;
  }
  if (field.type === "choice") {
    const none: [string, string][] = field.required || typeof field.default === "string" ? [] : [["", "(not set)"]];
    return <ChoiceField {...common} value={String(given ?? field.default ?? "")} options={[...none, ...field.choices.map((each): [string, string] => [each, each])]} set={set} />;
  }
  if (field.type === "child" || field.type === "variable") {
    const names = field.type === "child" ? node.children.map(nameOf) : [...visibleVariables(task, node.path).keys()];
    const none: [string, string][] = field.required ? [] : [["", "(none)"]];
    return <ChoiceField {...common} value={String(given ?? "")} options={[...none, ...names.map((each): [string, string] => [each, each])]} set={set} />;
  }
  const check = field.type === "expression" ? expressionCheck(node.path, field.key) : undefined;
  return <ValueField {...common} type={field.type} value={given} placeholder={field.required ? "needed" : String(field.default ?? "")} set={set} {...(check ? { check } : {})} />;
}

const LABELS: Record<string, string> = {
  precondition: "Precondition",
  memory: "With memory",
  times: "Times",
  seconds: "Seconds",
  child_first: "Ticks the child before checking the clock",
  if: "Only while",
  while: "While",
  on_value: "Value",
  default: "Otherwise",
  items: "List",
  item: "Item",
  policy: "Needs",
  cancel: "The other children",
  order: "Order",
  prompt: "Decide after each child",
  retick: "Tick finished children again",
  task: "File",
  initial: "Begins with",
  as: "Always ends with",
};

const DOCS: Record<string, string> = {
  precondition: "If false on entry, the node fails at once.",
  memory: "No: reactive, decided again on every tick.",
  child_first: "py_trees' order: what ends at the deadline has ended. No: at the deadline nothing begins or is ticked any more.",
  prompt: "Once decided, later children are not ticked.",
  retick: "Children that have ended are activated again on every tick, until it is decided.",
};
