/** How a node ends, what each end means, and where it leads. */
import type { JSX } from "react";

import { nameOf, parentOf } from "../../model/commands";
import { hasEdges, kindOf } from "../../model/kinds";
import type { NodeView } from "../../protocol/generated";
import { edit } from "../../store/editing";
import { askChoice, askText } from "../../store/ask";
import { connect, disconnect } from "../../store/flowing";
import { nameCheck, renameOutcome } from "../../store/gestures";
import { useRun } from "../../store/run";

export function OutcomesForm({ node, locked }: { node: NodeView; locked: boolean }): JSX.Element {
  const own = (node.fields["outcomes"] ?? {}) as Record<string, string>;
  return (
    <>
      <h3>Outcomes</h3>
      <table className="outcomes">
        <thead>
          <tr>
            <th scope="col">Outcome</th>
            <th scope="col">Means</th>
            <th scope="col">Leads to</th>
          </tr>
        </thead>
        <tbody>
          {rows(node).map((outcome) => (
            <OutcomeRow key={outcome} node={node} outcome={outcome} locked={locked} declared={outcome in own} />
          ))}
        </tbody>
      </table>
      {!locked && kindOf(node.kind)?.declares && <button onClick={() => void addOutcome(node)}>New outcome</button>}
    </>
  );
}

/** The node's outcomes, and the finer ones (`failure.no_ik`) that lead somewhere. */
function rows(node: NodeView): string[] {
  const finer = node.on.map((edge) => edge.outcome).filter((label) => !(label in node.outcomes));
  return [...Object.keys(node.outcomes), ...finer];
}

interface RowProps {
  readonly node: NodeView;
  readonly outcome: string;
  readonly locked: boolean;
  readonly declared: boolean;
}

function OutcomeRow({ node, outcome, locked, declared }: RowProps): JSX.Element {
  const parent = useRun((s) => s.index.byPath.get(parentOf(node.path) ?? ""));
  const ends = useRun((s) => s.task.outcomes);
  const target = node.on.find((edge) => edge.outcome === outcome)?.target ?? "";
  const base = outcome.split(".")[0] as string;
  const meaning = node.outcomes[base];
  const machine = hasEdges(parent);
  const targets = parent === undefined ? Object.keys(ends) : [...(machine ? parent.children.map(nameOf) : []), ...Object.keys(parent.outcomes)];
  const fixed = outcome !== base || (node.kind !== "leaf" && !declared);
  return (
    <tr>
      <th scope="row">{outcome}</th>
      <td>
        <select
          aria-label={`Meaning of ${outcome}`}
          value={meaning ?? ""}
          disabled={locked || fixed}
          onChange={(event) => void edit({ do: "set_meaning", path: node.path, outcome, meaning: event.target.value })}
        >
          {meaning === undefined && <option value="">?</option>}
          <option value="success">success</option>
          <option value="failure">failure</option>
        </select>
      </td>
      <td>
        <select
          aria-label={`Target of ${outcome}`}
          value={target}
          disabled={locked}
          onChange={(event) => void (event.target.value === "" ? disconnect(node.path, outcome, false) : connect(node.path, outcome, event.target.value))}
        >
          <option value="">{machine ? "(nowhere)" : "(by meaning)"}</option>
          {target !== "" && !targets.includes(target) && <option value={target}>{target}?</option>}
          {targets.map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
        </select>
        {declared && !locked && (
          <button className="link" aria-label={`Rename the outcome ${outcome}`} onClick={() => void renameOutcome(node, outcome)}>
            Rename
          </button>
        )}{" "}
        {declared && !locked && (
          <button className="link" aria-label={`Remove the outcome ${outcome}`} onClick={() => void edit({ do: "unset", path: node.path, key: ["outcomes", outcome] }, node.path)}>
            Remove
          </button>
        )}
      </td>
    </tr>
  );
}

async function addOutcome(node: NodeView): Promise<void> {
  const name = await askText({ title: `New outcome of ${node.name}`, label: "Name", initial: "", check: nameCheck(Object.keys(node.outcomes)) });
  if (name === null) return;
  const meaning = await askChoice({
    title: `What does ${name} mean?`,
    label: "Meaning",
    options: [
      { value: "success", label: "success", detail: "The parent continues" },
      { value: "failure", label: "failure", detail: "The parent tries something else" },
    ],
  });
  if (meaning !== null) await edit({ do: "set", path: node.path, key: ["outcomes", name], value: meaning }, node.path);
}
