/** Dragging: things are moved by the mouse, over the level plane through where they are held, or up and down. */
import { type PerspectiveCamera, Raycaster, Vector2, Vector3 } from "three";

/** Told of what is dragged, by its name in the scene. Who is told shows it where it is by then. */
export interface Dragging {
  take(name: string): void;
  /** So far from where it was when it was taken: x y z [m]. */
  drag(by: readonly [number, number, number]): void;
  drop(): void;
  /** It goes back to where it was taken. */
  back(): void;
}

/** Where a thing is held, in the world [m]. */
export interface Hold {
  readonly name: string;
  readonly at: Vector3;
}

/** Of a look from nearly above, the mouse would move things up without end. */
const STEEPEST = 0.3;
/** A look along the ground would move things to the horizon: they stay within so many times their distance when they were taken. */
const FARTHEST = 4;

/** Things are dragged over the level plane through where they are held, with Shift up and down; elsewhere the camera is turned. */
export function makeDrag(canvas: HTMLCanvasElement, camera: PerspectiveCamera, under: (ray: Raycaster) => Hold | null, point: (name: string) => void, told: Dragging): () => void {
  let held: (Hold & { readonly pointer: number; readonly by: Vector3; readonly far: number; last: PointerEvent }) | null = null;
  const ray = new Raycaster();
  function aim({ clientX, clientY }: PointerEvent): Raycaster {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    camera.updateMatrixWorld();
    ray.setFromCamera(new Vector2(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2), camera);
    return ray;
  }
  /** Where the mouse is on the level plane at that height; null where it is beside it. */
  function level(event: PointerEvent, height: number, far: number): Vector3 | null {
    const { origin, direction } = aim(event).ray;
    const away = (height - origin.z) / direction.z;
    return away > 0 && away < far ? origin.clone().addScaledVector(direction, away) : null;
  }
  function look(event: PointerEvent): void {
    const name = (held ?? under(aim(event)))?.name ?? "";
    canvas.style.cursor = held ? "grabbing" : name ? "grab" : "";
    point(name);
  }
  function leave(): void {
    held = null;
    canvas.style.cursor = "";
    point("");
  }
  function down(event: PointerEvent): void {
    const hold = held === null && event.button === 0 && !event.ctrlKey && !event.metaKey ? under(aim(event)) : null;
    if (held === null && hold === null) return;
    event.stopImmediatePropagation(); // the camera stays where it is
    if (hold === null) return;
    held = { ...hold, pointer: event.pointerId, by: new Vector3(), far: FARTHEST * camera.position.distanceTo(hold.at), last: event };
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    told.take(hold.name);
    look(event);
  }
  function move(event: PointerEvent): void {
    if (held === null) {
      if (event.buttons === 0) look(event);
      return;
    }
    if (event.pointerId !== held.pointer) return;
    const { by, last, far } = held;
    const at = held.at.clone().add(by);
    if (event.shiftKey) {
      const away = at.clone().sub(camera.position);
      const dot = (2 * away.length() * Math.tan(camera.fov * (Math.PI / 360))) / Math.max(1, canvas.clientHeight);
      by.z -= ((event.clientY - last.clientY) * dot) / Math.max(STEEPEST, Math.hypot(away.x, away.y) / away.length());
    } else {
      const [from, to] = [level(last, at.z, far), level(event, at.z, far)];
      if (from && to) by.add(to.sub(from));
      else if (to === null) return;
    }
    held.last = event;
    told.drag(by.toArray());
  }
  function up(event: PointerEvent): void {
    if (event.pointerId !== held?.pointer) return;
    held = null;
    told.drop();
    look(event);
  }
  function back(event: Event): void {
    if (held === null || (event instanceof KeyboardEvent && event.key !== "Escape")) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    leave();
    told.back();
  }
  const off = new AbortController();
  const on = { signal: off.signal, capture: true };
  canvas.addEventListener("pointerdown", down, on);
  canvas.addEventListener("pointermove", move, on);
  canvas.addEventListener("pointerup", up, on);
  canvas.addEventListener("pointercancel", back, on);
  canvas.addEventListener("pointerleave", () => held === null && leave(), on);
  canvas.addEventListener("keydown", back, on);
  return () => off.abort();
}
