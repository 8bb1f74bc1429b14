/** The tree of the task. Statuses reach the nodes through the store, never through the node list. */
import { Background, Controls, type Edge, MiniMap, type Node, Position, ReactFlow, useReactFlow,
  useStore,
  type Viewport,
} from "@xyflow/react";
import { type JSX, useEffect, useMemo } from "react";

import { type Box, layoutTree } from "../model/layout";
import type { Moment, TaskIndex } from "../model/status";
import type { TaskView } from "../protocol/generated";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { Detail } from "./Detail";
import { TreeNode } from "./TreeNode";

const NODE_TYPES = { task: TreeNode };
/** Above this number only nodes in sight are mounted. */
const CULL_ABOVE = 150;
const READABLE_ZOOM = 0.8;

export function TreeCanvas(): JSX.Element {
  const task = useRun((s) => s.task);
  const boxes = useMemo(() => layoutTree(task.nodes), [task]);
  const nodes = useMemo(() => flowNodes(task, boxes), [task, boxes]);
  const edges = useMemo(() => flowEdges(task), [task]);
  const { select, mark } = usePage.getState();
  const setFollow = usePage((s) => s.setFollow);
  return (
    <ReactFlow
      key={task.path}
      nodes={nodes}
      edges={edges}
      nodeTypes={NODE_TYPES}
      nodesDraggable={false}
      nodesConnectable={false}
      nodesFocusable={false}
      edgesFocusable={false}
      elementsSelectable={false}
      onlyRenderVisibleElements={nodes.length > CULL_ABOVE}
      minZoom={0.1}
      maxZoom={2}
      fitView
      fitViewOptions={{ padding: 0.04, maxZoom: 1.1 }}
      onNodeClick={(event, node) => (event.ctrlKey || event.metaKey || event.shiftKey ? mark(node.id) : select(node.id))}
      onNodeDoubleClick={(_, node) => {
        usePage.getState().enter(node.id);
        usePage.getState().setView("flow");
      }}
      zoomOnDoubleClick={false}
      onMoveStart={(event) => {
        if (event) setFollow(false);
      }}
      aria-label="Tree of the task; the outline has the same content for keyboards"
    >
      <Background gap={24} />
      <Controls showInteractive={false} />
      {nodes.length > 12 && <MiniMap pannable zoomable style={{ width: 140, height: 96 }} />}
      <Detail />
      <Follower boxes={boxes} />
    </ReactFlow>
  );
}

/** Keeps the running leaf in sight, and brings a node that was selected elsewhere into sight. */
function Follower({ boxes }: { boxes: ReadonlyMap<string, Box> }): null {
  const { setCenter, getZoom, getViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const follow = usePage((s) => s.follow);
  const selected = usePage((s) => s.selected);
  const running = useRun((s) => (s.cursor === null && s.complete ? null : runningLeaf(s.index, s.moment)));
  const target = follow && running ? running : null;
  useEffect(() => {
    const box = target ? boxes.get(target) : undefined;
    const readable = getZoom() >= READABLE_ZOOM;
    if (!box || (readable && isInSight(box, getViewport(), width, height))) return;
    void setCenter(...centre(box), { zoom: Math.max(getZoom(), READABLE_ZOOM), duration: pace() });
  }, [target, boxes, setCenter, getZoom, getViewport, width, height]);
  useEffect(() => {
    const box = selected ? boxes.get(selected) : undefined;
    if (!box || selected === "/" || isInSight(box, getViewport(), width, height)) return;
    void setCenter(...centre(box), { zoom: getZoom(), duration: pace() });
  }, [selected, boxes, setCenter, getZoom, getViewport, width, height]);
  return null;
}

function flowNodes(task: TaskView, boxes: ReadonlyMap<string, Box>): Node[] {
  return task.nodes.map((node) => {
    const { x, y, width, height } = boxes.get(node.path) as Box;
    const handle = { width: 1, height: 1, y: 25 };
    return {
      id: node.path,
      type: "task",
      position: { x, y },
      data: { node },
      width,
      height,
      measured: { width, height },
      handles: [
        { type: "target", position: Position.Left, x: 0, ...handle },
        { type: "source", position: Position.Right, x: width, ...handle },
      ],
    };
  });
}

function flowEdges(task: TaskView): Edge[] {
  return task.nodes
    .filter((node) => node.parent !== null)
    .map((node) => ({ id: `e:${node.path}`, source: node.parent as string, target: node.path, focusable: false }));
}

function runningLeaf(index: TaskIndex, moment: Moment): string | null {
  let found: string | null = null;
  for (const [path, status] of moment.nodes) {
    if (status.phase === "running" && index.byPath.get(path)?.kind === "leaf") found = path;
  }
  return found;
}

function centre(box: Box): [number, number] {
  return [box.x + box.width / 2, box.y + box.height / 2];
}

function pace(): number {
  return matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 300;
}

function isInSight(box: Box, view: Viewport, width: number, height: number): boolean {
  const left = box.x * view.zoom + view.x;
  const top = box.y * view.zoom + view.y;
  return left >= 0 && top >= 0 && left + box.width * view.zoom <= width && top + box.height * view.zoom <= height;
}
