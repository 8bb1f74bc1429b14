/** What a robot does, drawn: the way that its hand goes, what of it lies ahead, what else is planned, and where it presses and how hard. */
import { CatmullRomCurve3, Color, ConeGeometry, CylinderGeometry, InstancedMesh, Mesh, MeshBasicMaterial, type MeshStandardMaterial, Object3D, SphereGeometry, TubeGeometry, Vector3 } from "three";

import { along, newtonsOf, REACH, type Press, type Stand, type Way } from "../../model/timeline";
import type { GeometryView } from "../../protocol/generated";
import type { Robot } from "./body";

const UP = new Vector3(0, 1, 0);
/** How far the dots of a planned way are from each other [m]. */
const GAP = 0.02;

export interface Traces {
  /** The ways and the contacts at a moment; the robot stands elsewhere after that. */
  of(stand: Stand): Object3D[];
  /** Links that press glow. */
  glow(stand: Stand | null): void;
}

export function makeTraces(canvas: HTMLCanvasElement, view: GeometryView, robot: Robot, held: ReadonlyMap<string, Object3D>): Traces {
  const color = (name: string): Color => new Color(getComputedStyle(canvas).getPropertyValue(name).trim());
  const traced = new WeakMap<Way["points"], Vector3[]>();
  /** The line that the hand goes along; none where it stays. */
  function line(way: Way, joints: ReadonlyMap<string, number>): CatmullRomCurve3 | null {
    const moved = new Set(way.points[0]?.keys());
    // The hand of the arm that goes there: it hangs on the arm's last joint.
    const hand = [...held].find(([name]) => moved.has(view.groups[view.grasp[name]?.group ?? ""]?.at(-1) ?? ""))?.[1];
    const last = hand ?? robot.links.get(view.joints.findLast((joint) => moved.has(joint.name))?.child ?? "");
    if (last === undefined || way.points.length < 2) return null;
    const points = traced.get(way.points) ?? way.points.map((point) => {
      robot.stand(new Map([...joints, ...point]));
      robot.root.updateMatrixWorld(true);
      return last.getWorldPosition(new Vector3());
    });
    traced.set(way.points, points);
    return curved(points);
  }
  function goes(curve: CatmullRomCurve3, way: Way, joints: ReadonlyMap<string, number>): Object3D[] {
    const at = along(way.points, joints);
    const here = curve.getPoint(at / (way.points.length - 1));
    const [behind, ahead] = [curved([...curve.points.slice(0, Math.ceil(at)), here]), curved([here, ...curve.points.slice(Math.floor(at) + 1)])];
    return [...(behind ? [gone(behind, false, 0)] : []), ...(ahead ? [planned(ahead)] : [])];
  }
  function gone(curve: CatmullRomCurve3, over: boolean, age: number): Mesh {
    return new Mesh(new TubeGeometry(curve, 96, over ? 0.003 : 0.006, 6), new MeshBasicMaterial({ color: color(over ? "--quiet" : "--way"), transparent: true, opacity: over ? 0.8 / (1 + age) : 1 }));
  }
  function planned(curve: CatmullRomCurve3): InstancedMesh {
    const dots = curve.getSpacedPoints(Math.max(2, Math.round(curve.getLength() / GAP)));
    const made = new InstancedMesh(new SphereGeometry(0.006, 8, 6), new MeshBasicMaterial({ color: color("--plan") }), dots.length);
    put(made, dots.map((dot) => [dot, UP, 1]));
    return made;
  }
  /** An arrow ends where the link presses, and points as it pushes; it is seen through the hand. */
  function contacts(press: readonly Press[], newtons: number): Object3D[] {
    const arrows = press.map(({ at, force }) => {
      const push = new Vector3(...(force as [number, number, number])).multiplyScalar(REACH / newtons);
      return { tip: new Vector3(...(at as [number, number, number])), push, along: push.clone().normalize(), head: Math.min(0.014, push.length() / 2) };
    });
    const over = new MeshBasicMaterial({ color: color("--force"), depthTest: false, transparent: true });
    const made = [
      new InstancedMesh(new SphereGeometry(0.0035, 8, 6), over, arrows.length),
      new InstancedMesh(new CylinderGeometry(0.0018, 0.0018, 1, 6).translate(0, -0.5, 0), over, arrows.length),
      new InstancedMesh(new ConeGeometry(0.4, 1, 10).translate(0, -0.5, 0), over, arrows.length),
    ] as const;
    put(made[0], arrows.map(({ tip, along }) => [tip, along, 1]));
    put(made[1], arrows.map(({ tip, push, along, head }) => [tip.clone().addScaledVector(along, -head), along, new Vector3(1, Math.max(1e-4, push.length() - head), 1)]));
    put(made[2], arrows.map(({ tip, along, head }) => [tip, along, head]));
    for (const each of made) each.renderOrder = 1;
    return [...made];
  }
  return {
    of: (stand) => {
      const drawn = (ways: readonly Way[], draw: (curve: CatmullRomCurve3, way: Way, age: number) => Object3D | Object3D[]): Object3D[] =>
        ways.flatMap((way, age) => {
          const curve = line(way, stand.joints);
          return curve ? draw(curve, way, age) : [];
        });
      return [...drawn(stand.ways, (curve, way, age) => (way.over ? gone(curve, true, age) : goes(curve, way, stand.joints))), ...drawn(stand.plans, planned), ...(stand.press.length > 0 ? contacts(stand.press, newtonsOf(stand.hardest)) : [])];
    },
    glow: (stand) => {
      const hot = color("--failure");
      const pointed = new Set(stand?.press.map(({ link }) => link));
      for (const [name, link] of robot.links) {
        const force = stand?.touch.get(name);
        // Where arrows tell how hard, the glow only tells which links.
        const share = force === undefined ? 0 : pointed.has(name) ? 0.3 : Math.min(1, 0.35 + force / 8);
        for (const part of link.children) {
          const material = part instanceof Mesh ? (part.material as MeshStandardMaterial) : null;
          material?.emissive.copy(hot).multiplyScalar(share);
        }
      }
    },
  };
}

/** A line through points; none where they are all in one place. */
function curved(points: Vector3[]): CatmullRomCurve3 | null {
  return points.every((point) => point.distanceTo(points[0] as Vector3) < 0.005) ? null : new CatmullRomCurve3(points);
}

/** Put the pieces of a drawing: where, which way their y goes, and how large they are. */
function put(made: InstancedMesh, pieces: readonly (readonly [Vector3, Vector3, Vector3 | number])[]): void {
  const one = new Object3D();
  pieces.forEach(([at, along, size], number) => {
    one.position.copy(at);
    one.quaternion.setFromUnitVectors(UP, along);
    if (typeof size === "number") one.scale.setScalar(size);
    else one.scale.copy(size);
    one.updateMatrix();
    made.setMatrixAt(number, one.matrix);
  });
}
