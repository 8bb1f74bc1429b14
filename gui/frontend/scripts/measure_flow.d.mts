interface Rect {
  x: number;
  y: number;
  width: number;
  height: number;
}
export interface Measured {
  boxes: number;
  edges: number;
  overlaps: number;
  behind: number;
  covered: number;
  crossings: number;
  ahead: number;
  straight: number;
  width: number;
  height: number;
}
export function measureFlow(chart: {
  boxes: (Rect & { id: string; parent: string | null })[];
  edges: { id: string; source: string; target: string; meaning: string; points: { x: number; y: number }[]; label: Rect | null }[];
}): Measured;
