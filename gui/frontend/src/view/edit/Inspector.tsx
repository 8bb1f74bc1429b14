/** The selected node as forms: what it is, its settings, ports, outcomes, variables, and what is wrong with it. */
import type { JSX } from "react";
import { nameOf, parentOf } from "../../model/commands";
import { hasEdges, kindTitle } from "../../model/kinds";
import { seconds, statusText } from "../../model/words";
import { IDLE } from "../../model/status";
import type { NodeView } from "../../protocol/generated";
import { ACTIONS, actionTitle } from "../../store/actions";
import { expecting } from "../../store/ask";
import { edit } from "../../store/editing";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { ProblemList } from "../Foot";
import { closeOnEscape } from "../TopBar";
import { KindIcon, PhaseIcon } from "../icons";
import { NewPane } from "../marks";
import { ContainerForm } from "./ContainerForm";
import { FormBadge } from "./EditBar";
import { LeafForm } from "./LeafForm";
import { OutcomesForm } from "./OutcomesForm";
import { CommentForm, TaskForm } from "./TaskForm";
import { ValueField } from "./fields";

export function Inspector(): JSX.Element {
  const selected = usePage((s) => s.selected);
  const count = usePage((s) => s.marked.size);
  const node = useRun((s) => (selected === null ? undefined : s.index.byPath.get(selected)));
  return (
    <section className="panel inspector" aria-labelledby="node-title">
      <h2 id="node-title">Node</h2>
      <div className="scroll padded" tabIndex={0} role="group" aria-labelledby="node-title">
        {node ? <NodeForms key={node.path} node={node} count={count} /> : <p className="hint">Select a node in the tree or the outline.</p>}
      </div>
    </section>
  );
}

function NodeForms({ node, count }: { node: NodeView; count: number }): JSX.Element {
  const locked = useRun((s) => s.record !== null);
  const problems = useRun((s) => s.task.problems);
  const here = problems.filter((problem) => problem.path === node.path);
  const kind = node.kind === "leaf" ? node.label : (kindTitle(node.kind));
  return (
    <>
      <p className="node-title">
        <KindIcon kind={node.kind} id={node.label} /> <strong>{node.name}</strong> <code>{node.path}</code>
      </p>
      <p className="node-kind">
        {kind} {!locked && <button className="link" title={actionTitle("kind")} onClick={() => run("kind")}>Change</button>}
        <FormBadge path={node.path} />
        {node.kind === "subtask" && <NewPane task={node.label} at="/" words="Open the subtask in a pane of its own" />}
      </p>
      <RunStatus node={node} />
      {count > 1 && <p className="hint">{count} nodes are selected; actions are about all of them, fields about this one.</p>}
      {!locked && <Actions node={node} />}
      {here.length > 0 && <ProblemList problems={here} label="Problems of this node" short />}
      <ValueField
        label="Documentation"
        value={node.fields["doc"]}
        type="text"
        lines={2}
        placeholder={node.doc}
        disabled={locked}
        set={(value) => void edit(value === undefined ? { do: "unset", path: node.path, key: ["doc"] } : { do: "set", path: node.path, key: ["doc"], value })}
      />
      {node.kind === "leaf" || node.kind === "subtask" ? <LeafForm node={node} locked={locked} /> : null}
      {node.kind !== "leaf" && <ContainerForm node={node} locked={locked} />}
      <OutcomesForm node={node} locked={locked} />
      {!locked && <CommentForm path={node.path} />}
      {node.path === "/" && <TaskForm locked={locked} />}
    </>
  );
}

function RunStatus({ node }: { node: NodeView }): JSX.Element | null {
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  if (status.phase === "idle") return null;
  return (
    <p className={`phase-${status.phase}`}>
      <PhaseIcon phase={status.phase} /> {statusText(status)} at {seconds(status.since)}
      {status.message && <span className="reason"> {status.message}</span>}
    </p>
  );
}

const FOR_ALL = ["rename", "wrap", "unwrap", "copy", "cut", "paste", "up", "down", "connect", "free", "convert", "extract", "open", "remove"];

function Actions({ node }: { node: NodeView }): JSX.Element {
  const parent = useRun((s) => s.index.byPath.get(parentOf(node.path) ?? ""));
  const machine = hasEdges(node) || hasEdges(parent);
  const not = new Set([
    ...(node.path === "/" ? ["cut", "remove", "up", "down", "extract"] : []),
    ...(node.kind === "leaf" ? ["unwrap", "convert"] : []),
    ...(node.kind === "subtask" ? ["unwrap", "convert", "extract"] : ["open"]),
    ...(machine ? [] : ["free"]),
  ]);
  const offered = ACTIONS.filter((action) => FOR_ALL.includes(action.id) && !not.has(action.id));
  const button = (action: (typeof ACTIONS)[number]): JSX.Element => (
    <button key={action.id} title={actionTitle(action.id)} onClick={() => run(action.id)}>
      {SHORT[action.id] ?? action.title}
    </button>
  );
  return (
    <div className="actions" role="group" aria-label={`Actions for ${nameOf(node.path) || node.name}`}>
      {offered.filter((action) => FIRST.has(action.id)).map(button)}
      <details className="more" onKeyDown={closeOnEscape}>
        <summary>More</summary>
        <div className="more-list" onClick={(event) => event.currentTarget.closest("details")?.removeAttribute("open")}>
          {offered.filter((action) => !FIRST.has(action.id)).map(button)}
        </div>
      </details>
    </div>
  );
}

/** What is done most; the rest is a press away, and among the commands. */
const FIRST = new Set(["rename", "wrap", "connect", "open", "remove"]);

const SHORT: Record<string, string> = { wrap: "Wrap", connect: "Connect", free: "Connect free", convert: "Convert", extract: "Extract", open: "Open", up: "Up", down: "Down" };

function run(id: string): void {
  const action = ACTIONS.find((each) => each.id === id);
  void (action?.asks ? expecting(action.run) : action?.run());
}
