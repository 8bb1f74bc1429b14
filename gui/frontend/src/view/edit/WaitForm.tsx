/** Whom a parallel waits for before anything is decided: nobody, all, one, so many, or these children. */
import type { JSX } from "react";

import { nameOf } from "../../model/commands";
import { type Wait, waitOf } from "../../model/rows";
import type { FieldFace, NodeView } from "../../protocol/generated";
import { edit, settingNow } from "../../store/editing";
import { ChoiceField, ValueField } from "./fields";
import { Tick } from "./Tick";

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

export function WaitForm({ field, node, locked }: { field: FieldFace; node: NodeView; locked: boolean }): JSX.Element {
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
