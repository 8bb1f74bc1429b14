/** The tree of the task. Statuses reach the nodes through the store, never through the node list. */
import { type Node, Position, ReactFlow, useReactFlow, useStore, type Viewport, ViewportPortal } from "@xyflow/react";
import { type JSX, type MouseEvent, type RefObject, useCallback, useEffect, useMemo, useRef, useState } from "react";

import { type Box, layoutTree } from "../model/layout";
import { runningLeaf } from "../model/status";
import { FEW_NODES, hasRoomForMap, isInSight, LINE_AT, linesIn, nearestShown, unfolded } from "../model/visibility";
import type { NodeView } from "../protocol/generated";
import { openSubtask } from "../store/converting";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { subtitle, TreeNode } from "./TreeNode";
import { Detail, type Face, Ground, Overview, Sketch, useLeastZoom, useSight, Whole } from "./drawing";

const NODE_TYPES = { task: TreeNode };
const NO_EDGES: never[] = [];
const READABLE_ZOOM = 0.8;
/** Below this a whole tree isn't shown at first: nobody could read it. */
const LEAST_ZOOM = 0.35;

export function TreeCanvas(): JSX.Element {
  const path = useRun((s) => s.task.path);
  const all = useRun((s) => s.task.nodes);
  const closed = usePage((s) => s.closed);
  const shown = useMemo(() => unfolded(all, closed), [all, closed]);
  const boxes = useMemo(() => layoutTree(shown), [shown]);
  const sight = useSight(boxes);
  const { area, inside, sketched, real } = sight;
  const elements = sketched ? real : inside;
  const known = useRef(new Map<string, Node>());
  const nodes = useMemo(() => drawn(shown.filter((node) => elements.has(node.path)), boxes, known), [elements, shown, boxes]);
  const strokes = useMemo(() => [{ path: linesIn(area, shown, boxes), color: "line-strong", width: 1 }], [area, shown, boxes]);
  const byPath = useRun((s) => s.index.byPath);
  const faceOf = useCallback((path: string): Face => faceIn(byPath.get(path)), [byPath]);
  const mapped = useStore((s) => hasRoomForMap(s.width)) && shown.length > FEW_NODES;
  const leastZoom = useLeastZoom(boxes);
  const [begun, setBegun] = useState("");
  const press = (event: MouseEvent, path: string | null): void => {
    if (path === null) return;
    const { select, mark } = usePage.getState();
    (event.ctrlKey || event.metaKey || event.shiftKey ? mark : select)(path);
  };
  const enterAt = (path: string | null): void => {
    const view = byPath.get(path ?? "");
    if (view === undefined) return;
    if (view.kind === "subtask") return openSubtask(view);
    usePage.getState().enter(view.path);
    usePage.getState().setView("flow");
  };
  const setFollow = usePage((s) => s.setFollow);
  // A run that was followed is over: what came of it is seen as a whole.
  const live = useRun((s) => !s.complete && s.cursor === null);
  const [over, setOver] = useState("");
  const was = useRef(live);
  useEffect(() => {
    const { record, complete, cursor } = useRun.getState();
    if (was.current && complete && cursor === null && usePage.getState().follow) setOver(record?.id ?? "");
    was.current = live;
  }, [live]);
  return (
    <ReactFlow
      key={path}
      nodes={nodes}
      edges={NO_EDGES}
      nodeTypes={NODE_TYPES}
      nodesDraggable={false}
      nodesConnectable={false}
      nodesFocusable={false}
      edgesFocusable={false}
      elementsSelectable={false}
      onInit={() => setBegun(path)}
      className={sight.look}
      minZoom={leastZoom}
      maxZoom={2}
      onMouseMove={() => sight.dragged(null)}
      onDragOver={sight.dragged}
      onPaneClick={(event) => press(event, sight.at(event))}
      onDoubleClick={(event) => enterAt(sight.at(event))}
      onNodeClick={(event, node) => press(event, node.id)}
      onNodeDoubleClick={(_, node) => enterAt(node.id)}
      zoomOnDoubleClick={false}
      onMoveStart={(event) => {
        if (event) setFollow(false);
      }}
      attributionPosition="bottom-center"
      aria-label="Tree of the task; the outline has the same content for keyboards"
    >
      <ViewportPortal>
        {!sketched && <Ground area={area} />}
        <Sketch sight={sight} boxes={boxes} strokes={strokes} faceOf={faceOf} />
      </ViewportPortal>
      <Whole key={path} boxes={boxes} begun={begun === path} least={LEAST_ZOOM} begin={(_, __, height) => rootIn(boxes.get("/"), height)} over={over} />
      {mapped && <Overview boxes={boxes} />}
      <Detail />
      <Follower boxes={boxes} begun={begun === path} mapped={mapped} />
    </ReactFlow>
  );
}

function faceIn(node: NodeView | undefined): Face {
  if (node === undefined) return { name: "", shape: "leaf" };
  const lines = [subtitle(node), ...node.on.map((edge) => `${edge.outcome} ${edge.ends ? "⇥" : "→"} ${edge.target}`)];
  return { name: node.name, shape: node.kind === "leaf" ? "leaf" : "container", lines };
}

/** From where the task begins, as large as can be read. */
function rootIn(root: Box | undefined, height: number): Viewport {
  const { x, y } = root ?? { x: 0, y: 0 };
  return { x: 24 - x * READABLE_ZOOM, y: height / 2 - (y + LINE_AT) * READABLE_ZOOM, zoom: READABLE_ZOOM };
}

/** Keeps the running leaf in sight, and brings a node that was selected elsewhere into sight. */
function Follower({ boxes, begun, mapped }: { boxes: ReadonlyMap<string, Box>; begun: boolean; mapped: boolean }): null {
  const { setCenter, setViewport, getZoom, getViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const follow = usePage((s) => s.follow);
  const selected = usePage((s) => s.selected);
  const running = useRun((s) => (s.cursor === null && s.complete ? null : runningLeaf(s.index, s.moment)));
  const target = follow && running ? nearestShown(running, boxes) : null;
  useEffect(() => {
    const box = target ? boxes.get(target) : undefined;
    const readable = getZoom() >= READABLE_ZOOM;
    if (!box || (readable && isInSight(box, getViewport(), width, height, mapped))) return;
    void setCenter(...centre(box), { zoom: Math.max(getZoom(), READABLE_ZOOM), duration: pace() });
  }, [target, boxes, setCenter, getZoom, getViewport, width, height, mapped]);
  const seen = useRef({ selected, width, height });
  useEffect(() => {
    const box = selected ? boxes.get(selected) : undefined;
    const before = seen.current;
    const resized = begun && (before.width !== width || before.height !== height);
    if (begun) seen.current = { selected, width, height };
    // What is shown at first is found before; then comes the node that was selected in another view. The root, which is
    // selected until something else is, is looked for only when somebody goes to it, or a pane beside this one comes or goes.
    if (!begun || !box || (selected === "/" && before.selected === "/" && !resized)) return;
    // A motion that is under way leads to where the middle was.
    if (resized) void setViewport(getViewport());
    if (isInSight(box, getViewport(), width, height, mapped)) return;
    if (selected === "/" && resized) void setViewport(rootIn(box, height));
    else void setCenter(...centre(box), { zoom: getZoom(), duration: resized ? 0 : pace() });
  }, [selected, boxes, begun, setCenter, setViewport, getZoom, getViewport, width, height, mapped]);
  return null;
}

/** Nodes as the canvas takes them; those that are drawn already stay the same objects, so that nothing of them is done again. */
function drawn(nodes: readonly NodeView[], boxes: ReadonlyMap<string, Box>, known: RefObject<Map<string, Node>>): Node[] {
  const now = nodes.map((node) => {
    const box = boxes.get(node.path) as Box;
    const before = known.current.get(node.path);
    const same = before?.data["node"] === node && before.position.x === box.x && before.position.y === box.y && before.height === box.height;
    return same ? before : canvasNode(node, box);
  });
  known.current = new Map(now.map((node) => [node.id, node]));
  return now;
}

function canvasNode(node: NodeView, { x, y, width, height }: Box): Node {
  const handle = { width: 1, height: 1, y: LINE_AT };
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
}

function centre(box: Box): [number, number] {
  return [box.x + box.width / 2, box.y + box.height / 2];
}

function pace(): number {
  return matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 300;
}
