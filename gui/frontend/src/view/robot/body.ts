/** A robot as objects of three: each joint turns or shifts what hangs on it, so that a moment is a few numbers. */
import { BoxGeometry, BufferAttribute, BufferGeometry, Color, CylinderGeometry, DoubleSide, Group, InstancedMesh, Matrix4, Mesh, MeshStandardMaterial, type Object3D, Points, PointsMaterial, Quaternion, SphereGeometry, Vector3 } from "three";

import type { CloudView, GeometryView, JointView, MeshView, SceneItem, ShapeView } from "../../protocol/generated";

const GREY = new Color(0.72, 0.74, 0.77);
const SIDES = 32;

export interface Robot {
  readonly root: Group;
  readonly links: ReadonlyMap<string, Group>;
  /** Put the joints where they were measured; the others rest. */
  stand(joints: ReadonlyMap<string, number>): void;
}

export function makeRobot(view: GeometryView): Robot {
  const meshes = view.meshes.map(triangles);
  const root = new Group();
  const links = new Map<string, Group>();
  for (const [name, shapes] of Object.entries(view.links)) {
    const group = new Group();
    group.name = name;
    for (const shape of shapes) group.add(body(shape, shape.kind === "mesh" ? meshes[shape.mesh] : undefined, colorOf(shape.color)));
    links.set(name, group);
  }
  const moving = new Map<string, Object3D>();
  for (const joint of view.joints) {
    const fixed = new Group();
    place(fixed, joint.at);
    const mover = new Group();
    fixed.add(mover);
    moving.set(joint.name, mover);
    const child = links.get(joint.child);
    if (child) mover.add(child);
    (links.get(joint.parent) ?? root).add(fixed);
  }
  for (const link of links.values()) if (link.parent === null) root.add(link);
  return { root, links, stand: (joints) => view.joints.forEach((joint) => move(joint, moving.get(joint.name), positionOf(joint, joints, view))) };
}

function positionOf(joint: JointView, joints: ReadonlyMap<string, number>, view: GeometryView): number {
  const { mimic } = joint;
  if (mimic) return mimic.multiplier * (joints.get(mimic.joint) ?? view.rest[mimic.joint] ?? 0) + mimic.offset;
  return joints.get(joint.name) ?? view.rest[joint.name] ?? 0;
}

function move(joint: JointView, mover: Object3D | undefined, position: number): void {
  if (!mover) return;
  const axis = new Vector3(...(joint.axis as [number, number, number])).normalize();
  if (joint.type === "prismatic") mover.position.copy(axis.multiplyScalar(position));
  else if (joint.type === "revolute" || joint.type === "continuous") mover.quaternion.setFromAxisAngle(axis, position);
}

/** Put an object at x y z and the quaternion w x y z. */
export function place(object: Object3D, at: readonly number[]): void {
  const [x = 0, y = 0, z = 0, w = 1, i = 0, j = 0, k = 0] = at;
  object.position.set(x, y, z);
  object.quaternion.copy(new Quaternion(i, j, k, w));
}

function colorOf(color: readonly number[]): Color {
  const [red, green, blue] = color;
  return red === undefined || green === undefined || blue === undefined ? GREY : new Color(red, green, blue);
}

/** An object of the planning scene; what belongs to the room is seen through. */
export function makeItem(item: SceneItem, color: Color, look: MeshView | undefined): Mesh {
  const { kind } = item;
  const made = kind === "cells" ? cells(item, color, look) : body({ ...item, kind, color: [], mesh: -1 }, look && once(look, triangles), color);
  const material = made.material as MeshStandardMaterial;
  if (item.fixed) Object.assign(material, { transparent: true, opacity: 0.45 });
  // A surface of triangles is seen from both of its sides.
  if (kind === "mesh") material.side = DoubleSide;
  return made;
}

/** A map of cells, each as a box. */
function cells(item: SceneItem, color: Color, look: MeshView | undefined): InstancedMesh {
  const middles = look ? pointsOf(look) : new Float32Array(0);
  const side = item.size[0] ?? 0.01;
  const made = new InstancedMesh(new BoxGeometry(side, side, side), new MeshStandardMaterial({ color, roughness: 0.75, flatShading: true }), middles.length / 3);
  const at = new Matrix4();
  for (let cell = 0; cell < made.count; cell++) made.setMatrixAt(cell, at.makeTranslation(middles[3 * cell] ?? 0, middles[3 * cell + 1] ?? 0, middles[3 * cell + 2] ?? 0));
  place(made, item.at);
  return made;
}

/** What a camera saw, in its own colours where it has any. */
export function makeCloud(cloud: CloudView, color: Color): Points {
  return new Points(once(cloud, coloured), new PointsMaterial({ size: 0.006, vertexColors: cloud.colors !== "", ...(cloud.colors ? {} : { color }) }));
}

function body(shape: ShapeView, mesh: BufferGeometry | undefined, color: Color): Mesh {
  const made = new Mesh(mesh ?? solid(shape), new MeshStandardMaterial({ color, roughness: 0.75, metalness: 0.05, flatShading: true }));
  place(made, shape.at);
  return made;
}

function solid({ kind, size }: ShapeView): BufferGeometry {
  const [a = 0, b = 0, c = 0] = size;
  if (kind === "sphere") return new SphereGeometry(a, SIDES, SIDES / 2);
  // A cylinder of three stands along y, one of a URDF along z.
  if (kind === "cylinder") return new CylinderGeometry(a, a, b, SIDES).rotateX(Math.PI / 2);
  return new BoxGeometry(a, b, c);
}

const made_before = new WeakMap<object, BufferGeometry>();

/** The scene is put together anew whenever something moves; what things look like is worked out once. */
function once<T extends object>(look: T, make: (look: T) => BufferGeometry): BufferGeometry {
  const made = made_before.get(look) ?? make(look);
  made_before.set(look, made);
  return made;
}

function coloured(cloud: CloudView): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(pointsOf(cloud), 3));
  if (cloud.colors) made.setAttribute("color", new BufferAttribute(new Uint8Array(bytes(cloud.colors)), 3, true));
  return made;
}

function pointsOf({ points }: { points: string }): Float32Array<ArrayBuffer> {
  return new Float32Array(bytes(points));
}

function triangles(mesh: MeshView): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(pointsOf(mesh), 3));
  made.setIndex(new BufferAttribute(new Uint32Array(bytes(mesh.triangles)), 1));
  made.computeVertexNormals();
  return made;
}

function bytes(text: string): ArrayBuffer {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0)).buffer;
}
