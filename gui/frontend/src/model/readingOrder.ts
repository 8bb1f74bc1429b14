/** The order in which the nodes of a chart are read. */
import type { FlowEdge } from "./flow";

const RANK: Record<string, number> = { success: 0, failure: 2 };

/**
 * Followed along success first, an edge to what is still under way closes a loop; without these edges the chart has no
 * circles, and its order begins with the path of success.
 * @param first where it begins.
 */
export function readingOrder(ids: readonly string[], edges: readonly FlowEdge[], first: string | undefined): string[] {
  const after = new Map<string, FlowEdge[]>(ids.map((id) => [id, []]));
  for (const edge of edges) if (after.has(edge.target) && edge.source !== edge.target) after.get(edge.source)?.push(edge);
  for (const list of after.values()) list.sort((a, b) => (RANK[a.meaning] ?? 1) - (RANK[b.meaning] ?? 1));
  const roots = [...ids].sort((a, b) => Number(b === first) - Number(a === first));
  const loops = loopsOf(roots, after);
  const waits = new Map(ids.map((id) => [id, 0]));
  const wait = (id: string, by: number): number => {
    const now = (waits.get(id) ?? 0) + by;
    waits.set(id, now);
    return now;
  };
  for (const list of after.values()) for (const edge of list) if (!loops.has(edge)) wait(edge.target, 1);
  const ready = roots.filter((id) => waits.get(id) === 0).reverse();
  const order: string[] = [];
  for (let id = ready.pop(); id !== undefined; id = ready.pop()) {
    order.push(id);
    const next = (after.get(id) ?? []).filter((edge) => !loops.has(edge) && wait(edge.target, -1) === 0);
    ready.push(...next.map((edge) => edge.target).reverse());
  }
  return order;
}

/** Edges to what is still under way, when they are followed depth first. */
function loopsOf(roots: readonly string[], after: ReadonlyMap<string, FlowEdge[]>): Set<FlowEdge> {
  const under_way = new Map<string, boolean>();
  const loops = new Set<FlowEdge>();
  for (const root of roots) {
    if (under_way.has(root)) continue;
    const stack: [string, number][] = [[root, 0]];
    under_way.set(root, true);
    for (let top = stack.at(-1); top !== undefined; top = stack.at(-1)) {
      const edge = after.get(top[0])?.[top[1]++];
      if (edge === undefined) {
        under_way.set(top[0], false);
        stack.pop();
      } else if (under_way.get(edge.target)) loops.add(edge);
      else if (!under_way.has(edge.target)) {
        under_way.set(edge.target, true);
        stack.push([edge.target, 0]);
      }
    }
  }
  return loops;
}
