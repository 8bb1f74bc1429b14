/** A container's inside as a flow chart: drag from an outcome to where it leads, drag a node to pin it. */
import { Background, type Connection, Controls, type Edge, MarkerType, MiniMap, type Node, Position, ReactFlow, type ReactFlowInstance, useReactFlow, useStore } from "@xyflow/react";
import { type DragEvent, type JSX, useCallback, useEffect, useMemo, useRef, useState } from "react";

import { parentOf } from "../../model/commands";
import { FLOW_HEAD, isStart, PORT_HEIGHT, targetName } from "../../model/flow";
import { chartedIn, chartOf, type FlowChart, isCharted, pinAt } from "../../model/flowChart";
import type { Box } from "../../model/flowLayout";
import { FEW_NODES, hasRoomForMap, isInSight } from "../../model/visibility";
import { openSubtask } from "../../store/converting";
import { useDocument } from "../../store/document";
import { pin } from "../../store/editing";
import { beginWith, connect, disconnect } from "../../store/flowing";
import { connectFree } from "../../store/gestures";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { FormBadge } from "../edit/EditBar";
import { drop, isDrag } from "../hooks";
import { Detail, NewPane } from "../marks";
import { EndNode, FlowEdgeLine, FlowNode, StartNode } from "./FlowNode";

const NODE_TYPES = { node: FlowNode, end: EndNode, start: StartNode };
const EDGE_TYPES = { line: FlowEdgeLine };
/** Zoom at which a chart can be read. */
const READABLE = 0.75;
const NO_PINS: Record<string, number[]> = {};

export function FlowCanvas(): JSX.Element {
  const task = useRun((s) => s.task);
  const index = useRun((s) => s.index);
  const locked = useRun((s) => s.record !== null);
  const container = usePage((s) => s.container);
  useSelectedContainer();
  const pins = useDocument((s) => s.document?.layout.flow) ?? NO_PINS;
  const opened = usePage((s) => s.opened);
  const chart = useMemo(() => chartOf(task, index.byPath, container, opened, pins), [task, index, container, opened, pins]);
  const { flow, boxes } = chart;
  const key = `${task.path}:${container}`;
  const [begun, setBegun] = useState("");
  const [edge, setEdge] = useState<string | null>(null);
  const [dragged, setDragged] = useState<{ id: string; x: number; y: number } | null>(null);
  const nodes = useMemo(() => flowNodes(chart, dragged), [chart, dragged]);
  const edges = useMemo(() => flowEdges(chart, edge), [chart, edge]);
  const mapped = useStore((s) => hasRoomForMap(s.width)) && nodes.length > FEW_NODES;
  useEffect(() => setDragged(null), [boxes]);

  const onConnect = useCallback(({ source, sourceHandle, target }: Connection): void => {
    if (isStart(target)) return;
    if (chartedIn(source, container) !== chartedIn(target, container)) {
      useRun.getState().setError("An edge stays within its container: connect it to a sibling or to an end of the container.");
    } else if (isStart(source)) void beginWith(target);
    else void connect(source, sourceHandle ?? "success", targetName(target));
  }, [container]);
  const chosen = chart.edges.find((each) => each.id === edge);
  const canEdit = !locked;
  return (
    <section className="flow" aria-label="Flow chart" onDragOver={allow} onDrop={(event) => drop(event, { parent: container, index: index.byPath.get(container)?.children.length ?? 0 })}>
      <div className="flow-strip">
        <Breadcrumbs />
        <FormBadge path={container} />
        {flow.strip && <span>{flow.strip}</span>}
        {flow.machine && canEdit && <button onClick={() => void connectFree(container)}>Connect free outcomes</button>}
        {chosen && canEdit && !isStart(chosen.source) && (
          <span className="edge-tools" role="group" aria-label="Selected edge">
            {targetName(chosen.source)}.{chosen.outcome} → {targetName(chosen.target)}
            <button onClick={() => void disconnect(chosen.source, chosen.outcome, chosen.derived)}>Remove this edge</button>
          </span>
        )}
      </div>
      <ReactFlow
        key={key}
        nodes={nodes}
        edges={edges}
        nodeTypes={NODE_TYPES}
        edgeTypes={EDGE_TYPES}
        nodesDraggable={canEdit}
        nodesConnectable={canEdit}
        nodesFocusable={false}
        edgesFocusable={false}
        elementsSelectable
        deleteKeyCode={null}
        selectionKeyCode={null}
        multiSelectionKeyCode={null}
        minZoom={0.1}
        maxZoom={2}
        onInit={(canvas) => void showAll(canvas).then(() => setBegun(key))}
        onConnect={onConnect}
        onNodeClick={(event, node) => {
          setEdge(null);
          if (node.type !== "node") return;
          if (event.ctrlKey || event.metaKey || event.shiftKey) usePage.getState().mark(node.id);
          else usePage.getState().select(node.id);
        }}
        onNodeDoubleClick={(_, node) => {
          const view = index.byPath.get(node.id);
          if (view?.kind === "subtask") openSubtask(view);
          else if (view?.children.length) usePage.getState().enter(node.id);
        }}
        onEdgeClick={(_, clicked) => setEdge(clicked.id)}
        onPaneClick={() => setEdge(null)}
        onNodeDrag={(_, node) => setDragged({ id: node.id, ...node.position })}
        onNodeDragStop={(_, node) => {
          if (node.type === "node") void pin("flow", { [node.id]: pinAt(chart, node.id, node.position) });
        }}
        attributionPosition="bottom-center"
        aria-label="Flow chart of the container; the outline and the forms have the same content for keyboards"
      >
        <Background gap={24} />
        <Controls orientation="horizontal" showInteractive={false} />
        {mapped && <MiniMap pannable zoomable style={{ width: 140, height: 96 }} />}
        <Detail />
        <Keeper boxes={boxes} begun={begun === key} mapped={mapped} />
      </ReactFlow>
      <Pinned chart={chart} pins={pins} locked={locked} />
    </section>
  );
}

/** Show the whole chart, or its beginning where the whole would be too small to read. */
async function showAll(canvas: ReactFlowInstance): Promise<void> {
  await canvas.fitView({ padding: 0.06, maxZoom: 1.1 });
  const { zoom } = canvas.getViewport();
  if (zoom >= READABLE) return;
  const { x, y, height } = canvas.getNodesBounds(canvas.getNodes());
  const pane = document.querySelector(".flow .react-flow")?.clientHeight ?? 0;
  await canvas.setViewport({ x: 16 - x * READABLE, y: Math.max(16, (pane - height * READABLE) / 2) - y * READABLE, zoom: READABLE });
}

function allow(event: DragEvent): void {
  if (isDrag(event)) event.preventDefault();
}

/** Offers to place pinned nodes automatically again. */
function Pinned({ chart, pins, locked }: { chart: FlowChart; pins: Record<string, number[]>; locked: boolean }): JSX.Element | null {
  const here = chart.items.map(({ item }) => item.id).filter((id) => pins[id] !== undefined);
  if (here.length === 0 || locked) return null;
  return (
    <button className="tidy" onClick={() => void pin("flow", Object.fromEntries(here.map((id) => [id, null])))}>
      Tidy up ({here.length} pinned)
    </button>
  );
}

/** Goes to the container of a node that was selected elsewhere. */
function useSelectedContainer(): void {
  const selected = usePage((s) => s.selected);
  useEffect(() => {
    const { container, enter } = usePage.getState();
    const { byPath } = useRun.getState().index;
    const parent = selected === null ? null : parentOf(selected);
    if (selected === null || selected === container || isCharted(selected, container, usePage.getState().opened) || !byPath.has(selected)) return;
    if (selected === "/" || parent === null) enter("/");
    else enter(parent);
  }, [selected]);
}

/** Brings a node that was selected elsewhere into sight, and keeps the middle of the chart in the middle of its pane. */
function Keeper({ boxes, begun, mapped }: { boxes: ReadonlyMap<string, Box>; begun: boolean; mapped: boolean }): null {
  const selected = usePage((s) => s.selected);
  const { setCenter, setViewport, getZoom, getViewport } = useReactFlow();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const size = useRef({ width, height });
  useEffect(() => {
    const before = size.current;
    size.current = { width, height };
    const { x, y, zoom } = getViewport();
    // A pane beside this one has come or gone.
    if (begun && before.width > 0 && width > 0) void setViewport({ x: x + (width - before.width) / 2, y: y + (height - before.height) / 2, zoom });
  }, [begun, width, height, getViewport, setViewport]);
  useEffect(() => {
    const box = selected === null ? undefined : boxes.get(selected);
    if (!begun || !box || width === 0) return;
    if (!isInSight(box, getViewport(), width, height, mapped)) void setCenter(box.x + box.width / 2, box.y + box.height / 2, { zoom: getZoom(), duration: 0 });
  }, [selected, boxes, begun, width, height, mapped, setCenter, getZoom, getViewport]);
  return null;
}

function flowNodes({ items }: FlowChart, dragged: { id: string; x: number; y: number } | null): Node[] {
  return items.map(({ item, parent, box: { x, y, width, height } }) => {
    const position = dragged?.id === item.id ? { x: dragged.x, y: dragged.y } : { x, y };
    const handle = { width: 10, height: 10 };
    const target = { type: "target" as const, position: Position.Left, id: "in", x: -5, y: (item.kind === "end" ? height / 2 : 24) - 5, ...handle };
    const sources = item.ports.map((port, i) => ({ type: "source" as const, position: Position.Right, id: port.outcome, x: width - 5, y: FLOW_HEAD + (i + 0.5) * PORT_HEIGHT - 5, ...handle }));
    const start = { type: "source" as const, position: Position.Right, id: "", x: width - 5, y: height / 2 - 5, ...handle };
    return {
      id: item.id,
      type: item.kind,
      position,
      data: { item },
      width,
      height,
      measured: { width, height },
      draggable: item.kind === "node",
      handles: item.kind === "start" ? [start] : [target, ...sources],
      ...(parent === null ? {} : { parentId: parent }),
    };
  });
}

function flowEdges({ edges }: FlowChart, selected: string | null): Edge[] {
  return edges.map((edge) => ({
    id: edge.id,
    type: "line",
    data: { bends: edge.bends, bottom: edge.bottom },
    source: edge.source,
    sourceHandle: edge.outcome,
    target: edge.target,
    targetHandle: "in",
    label: edge.label || (edge.outcome === "" ? undefined : edge.outcome),
    selected: edge.id === selected,
    className: edge.derived ? "derived" : "stored",
    markerEnd: { type: MarkerType.ArrowClosed },
    focusable: false,
    interactionWidth: 18,
  }));
}

export function Breadcrumbs(): JSX.Element {
  const container = usePage((s) => s.container);
  const index = useRun((s) => s.index);
  const file = useRun((s) => s.task.path);
  const name = useRun((s) => s.task.name);
  const { enter, select } = usePage.getState();
  const chain: string[] = [];
  for (let at: string | null = container; at !== null; at = parentOf(at)) chain.unshift(at);
  return (
    <nav aria-label="Containers">
      <ol className="crumbs">
        {chain.map((path) => (
          <li key={path}>
            <button
              className="link"
              {...(path === container ? { "aria-current": "location" as const } : {})}
              onClick={() => {
                enter(path);
                select(path);
              }}
            >
              {path === "/" ? name : index.byPath.get(path)?.name}
            </button>
          </li>
        ))}
      </ol>
      <NewPane task={file} at={container} words="Open this container in a pane of its own" />
    </nav>
  );
}
