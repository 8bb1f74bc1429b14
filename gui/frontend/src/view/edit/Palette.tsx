/** What a task can be made of: found by typing, added by a press, dragged to a place. */
import { type JSX, useMemo, useState } from "react";
import { kinds } from "../../model/kinds";
import { NEW_COMPONENT, toBeMade } from "../../model/parts";
import { groupOf, GROUPS } from "../../model/words";
import { matching } from "../../model/commands";
import { useDocument } from "../../store/document";
import { add } from "../../store/gestures";
import { useRun } from "../../store/run";
import { dragNew } from "../hooks";
import { KindIcon } from "../icons";

interface Entry {
  readonly id: string;
  readonly label: string;
  readonly detail: string;
  readonly mark: string;
  readonly kind: string;
}

export function Palette(): JSX.Element {
  const catalog = useDocument((s) => s.catalog);
  const disabled = useRun((s) => s.record !== null);
  const path = useRun((s) => s.task.path);
  const [text, setText] = useState("");
  const groups = useMemo(() => {
    const entries: Entry[] = [
      ...kinds().filter((face) => face.kind !== "subtask").map((face) => ({ id: face.kind, label: face.title, detail: face.doc, mark: "containers", kind: face.kind })),
      ...catalog.nodes.map((face) => ({ id: face.id, label: face.id, detail: face.doc, mark: groupOf(face.id), kind: "leaf" })),
      ...(catalog.nodes.length === 0 ? [] : toBeMade(catalog.nodes)).map((face) => ({ id: face.id, label: face.id === NEW_COMPONENT ? "New component ..." : `${face.id} ...`, detail: face.doc, mark: groupOf(face.id), kind: "leaf" })),
      ...catalog.tasks.filter((face) => face.id !== path).map((face) => ({ id: face.id, label: face.id, detail: face.doc, mark: "tasks", kind: "subtask" })),
    ];
    const found = new Map<string, Entry[]>();
    for (const entry of matching(entries, text)) found.set(entry.mark, [...(found.get(entry.mark) ?? []), entry]);
    return found;
  }, [catalog, text, path]);
  return (
    <section className="panel palette" aria-labelledby="palette-title">
      <h2 id="palette-title">Palette</h2>
      <input className="palette-search" type="search" aria-label="Search the palette" placeholder="Type to find a node" value={text} onChange={(event) => setText(event.target.value)} />
      <div className="scroll" tabIndex={0} role="group" aria-labelledby="palette-title">
        {catalog.error && <p className="fault padded">{catalog.error}</p>}
        {[...groups].map(([name, entries]) => (
          <details key={`${name}${text ? "!" : ""}`} open={text !== "" || name === "containers"}>
            <summary>
              {GROUPS[name] ?? name} <span className="hint">{entries.length}</span>
            </summary>
            <ul>
              {entries.map((entry) => (
                <li key={entry.id}>
                  <button disabled={disabled} draggable={!disabled} title={entry.detail} onClick={() => void add(entry.id)} onDragStart={(event) => dragNew(event, entry.id)}>
                    <KindIcon kind={entry.kind} id={entry.id} /> {entry.label.replace(`${name}/`, "")}
                  </button>
                </li>
              ))}
            </ul>
          </details>
        ))}
        {groups.size === 0 && !catalog.error && <p className="hint padded">{catalog.nodes.length === 0 ? "Looking for nodes ..." : "Nothing is called like this."}</p>}
      </div>
    </section>
  );
}
