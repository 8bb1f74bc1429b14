// What can be counted about a flow chart as it is drawn: boxes, edges as lines of points, words on edges.
const EPS = 0.5;

/**
 * @param {{boxes: {id: string, parent: string | null, x: number, y: number, width: number, height: number}[],
 *   edges: {id: string, source: string, target: string, meaning: string, points: {x: number, y: number}[],
 *     label: {x: number, y: number, width: number, height: number} | null}[]}} chart
 */
export function measureFlow({ boxes, edges }) {
  const byId = new Map(boxes.map((box) => [box.id, box]));
  const around = (id) => {
    const all = new Set();
    for (let at = byId.get(id)?.parent; at; at = byId.get(at)?.parent) all.add(at);
    return all;
  };
  const holders = new Set(boxes.map((box) => box.parent).filter(Boolean));
  const labels = edges.filter((edge) => edge.label !== null);
  return {
    boxes: boxes.length,
    edges: edges.length,
    overlaps: pairs(boxes).filter(([a, b]) => !around(a.id).has(b.id) && !around(b.id).has(a.id) && lieOver(a, b)).length,
    behind: edges.filter((edge) => isBehind(edge, boxes, around, holders)).length,
    covered: labels.filter((edge) => isCovered(edge, boxes, edges, holders)).length,
    crossings: new Set(pairs(edges).flatMap(([a, b]) => crossings(a, b))).size,
    ...straightness(edges, byId),
    ...extent([...boxes, ...edges.flatMap(({ points }) => points.map((point) => ({ ...point, width: 0, height: 0 })))]),
  };
}

const pairs = (all) => all.flatMap((one, i) => all.slice(i + 1).map((other) => [one, other]));
const lieOver = (a, b, by = EPS) => a.x < b.x + b.width - by && b.x < a.x + a.width - by && a.y < b.y + b.height - by && b.y < a.y + a.height - by;
const pieces = (edge) => edge.points.slice(1).map((point, i) => [edge.points[i], point]);
const within = (box, margin) => ({ x: box.x + margin, y: box.y + margin, width: box.width - 2 * margin, height: box.height - 2 * margin });

/** Whether an edge runs behind a box: any in which it doesn't lie, and its own ends but for the border where it is fastened. */
function isBehind(edge, boxes, around, holders) {
  const inside = new Set([...around(edge.source), ...around(edge.target)]);
  return boxes.some((box) => {
    const own = box.id === edge.source || box.id === edge.target;
    if (inside.has(box.id) || (own && holders.has(box.id))) return false;
    return pieces(edge).some(([a, b]) => cuts(a, b, within(box, own ? 6 : 1)));
  });
}

/** Whether the words of an edge lie on another edge, on other words or on a box, but for a container around them. */
function isCovered(edge, boxes, edges, holders) {
  const words = within(edge.label, 1);
  if (boxes.some((box) => (holders.has(box.id) ? cutsBorder(box, words) : lieOver(box, words)))) return true;
  if (edges.some((other) => other !== edge && other.label !== null && lieOver(other.label, words))) return true;
  // Edges that share a way into their target lie on each other there: words on them are those of both.
  return edges.some((other) => other !== edge && pieces(other).some(([a, b]) => cuts(a, b, words)));
}

const cutsBorder = (box, words) => lieOver(box, words) && !(words.x >= box.x && words.y >= box.y && words.x + words.width <= box.x + box.width && words.y + words.height <= box.y + box.height);

/** The places where two edges cross: those that share a way are crossed there once. */
function crossings(a, b) {
  return pieces(a).flatMap(([p, q]) => pieces(b).flatMap(([r, s]) => (cross(p, q, r, s) ? [placeOf(p, q, r, s)] : [])));
}

function cross(a, b, c, d) {
  const side = (p, q, r) => (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  const [s1, s2, s3, s4] = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)];
  const e = 0.02;
  return ((s1 > e && s2 < -e) || (s1 < -e && s2 > e)) && ((s3 > e && s4 < -e) || (s3 < -e && s4 > e));
}

function placeOf(a, b, c, d) {
  const [u, v] = [{ x: b.x - a.x, y: b.y - a.y }, { x: d.x - c.x, y: d.y - c.y }];
  const t = ((c.x - a.x) * v.y - (c.y - a.y) * v.x) / (u.x * v.y - u.y * v.x);
  return `${Math.round(a.x + t * u.x)} ${Math.round(a.y + t * u.y)}`;
}

/** Of the edges that lead success ahead to a node that stands right of their source, and not round to another row: how many have no bend. */
function straightness(edges, byId) {
  const ahead = edges.filter((edge) => {
    const [from, to] = [byId.get(edge.source), byId.get(edge.target)];
    return edge.meaning === "success" && from && to && !edge.target.includes("#end") && edge.points.every(({ x }, i) => i === 0 || x > edge.points[i - 1].x - EPS) && to.x >= from.x + from.width;
  });
  const level = (edge) => Math.max(...edge.points.map((point) => point.y)) - Math.min(...edge.points.map((point) => point.y)) < 1.5;
  return { ahead: ahead.length, straight: ahead.filter(level).length };
}

function extent(boxes) {
  const right = Math.max(...boxes.map((box) => box.x + box.width));
  const low = Math.max(...boxes.map((box) => box.y + box.height));
  const left = Math.min(...boxes.map((box) => box.x));
  const top = Math.min(...boxes.map((box) => box.y));
  return { width: Math.round(right - left), height: Math.round(low - top) };
}

/** Whether the line from `p` to `q` goes through a box. */
function cuts(p, q, box) {
  let [from, to] = [0, 1];
  for (const [d, low, high, at] of [[q.x - p.x, box.x, box.x + box.width, p.x], [q.y - p.y, box.y, box.y + box.height, p.y]]) {
    if (Math.abs(d) < 1e-9) {
      if (at <= low || at >= high) return false;
      continue;
    }
    const [a, b] = [(low - at) / d, (high - at) / d].sort((one, other) => one - other);
    from = Math.max(from, a);
    to = Math.min(to, b);
    if (from >= to) return false;
  }
  return true;
}
