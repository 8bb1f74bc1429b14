/** The drawing: camera, light, ground, the robot, the scene around it, and poses; drawn only when something has changed. */
import { AmbientLight, AxesHelper, Box3, CanvasTexture, Color, DirectionalLight, EdgesGeometry, GridHelper, Group, InstancedMesh, LineBasicMaterial, LineSegments, type Material, Mesh, type MeshStandardMaterial, type Object3D, PerspectiveCamera, Points, type Raycaster, Scene, Sphere, Sprite, SpriteMaterial, SRGBColorSpace, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Stand } from "../../model/timeline";
import type { GeometryView, NamedPlace } from "../../protocol/generated";
import type { NamedCloud } from "../../store/live";
import { makeCloud, makeItem, makeRobot, place, type Robot } from "./body";
import { type Dragging, type Hold, makeDrag } from "./drag";
import { makeTraces } from "./traces";

const STEP = Math.PI / 18;
const AXES = 0.08;
/** Of a variable with more poses, such as a list of grasps, only the axes are drawn: names would cover each other. */
const NAMED = 3;
/** How much is seen of poses that something newer has taken the place of. */
const FADED = 0.3;

/** A pose to be drawn, and whether a newer one was written since. */
export interface Spot extends NamedPlace {
  readonly over?: boolean;
}

export type Side = "front" | "side" | "above" | "hand";

export interface Space {
  show(stand: Stand | null, places: readonly Spot[], clouds: readonly NamedCloud[], frames: boolean): void;
  /** Where the grasp frames are: hand -> x y z [m]. */
  grasps(): ReadonlyMap<string, readonly [number, number, number]>;
  from(side: Side): void;
  /** Look at the whole robot and what stands around it, as near as it fits. */
  fit(): void;
  /** How the robot stands with its joints there, drawn small on a canvas. */
  picture(joints: ReadonlyMap<string, number>, on: HTMLCanvasElement): void;
  turn(around: number, over: number): void;
  nearer(factor: number): void;
  /** What stands around the robot can be dragged from now on. */
  drags(told: Dragging): void;
  close(): void;
}

/** Throws where the browser can't draw in 3D. */
export function makeSpace(canvas: HTMLCanvasElement, view: GeometryView): Space {
  const renderer = new WebGLRenderer({ canvas, antialias: true });
  const scene = new Scene();
  const camera = new PerspectiveCamera(45, 1, 0.01, 50);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  controls.enableDamping = false;
  const sun = new DirectionalLight(0xffffff, 2);
  sun.position.set(2, -3, 4);
  const ground = new Group();
  const things = new Group();
  const robot = makeRobot(view);
  const held = new Map(Object.entries(view.grasp).map(([hand, frame]) => [hand, graspFrame(robot, frame)]));
  const axes = [...robot.links.values()].map((link) => addAxes(link, AXES * 0.7));
  const traces = makeTraces(canvas, view, robot, held);
  scene.add(new AmbientLight(0xffffff, 1.3), sun, ground, robot.root, things);
  robot.stand(new Map());

  let asked = 0;
  function draw(): void {
    if (asked !== 0) return;
    asked = requestAnimationFrame(() => {
      asked = 0;
      renderer.render(scene, camera);
    });
  }
  const dark = matchMedia("(prefers-color-scheme: dark)");
  function dress(): void {
    const word = (name: string): Color => new Color(getComputedStyle(canvas).getPropertyValue(name).trim());
    scene.background = word("--sunken");
    ground.clear();
    ground.add(new GridHelper(4, 20, word("--line-strong"), word("--line")).rotateX(Math.PI / 2));
    draw();
  }
  const sized = new ResizeObserver(() => {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement ?? canvas;
    if (width === 0 || height === 0) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    aim?.();
    draw();
  });
  sized.observe(canvas.parentElement ?? canvas);
  controls.addEventListener("change", draw);
  dark.addEventListener("change", dress);

  /** Nothing goes out of sight when the pane grows narrow, until somebody has turned the drawing. */
  let aim: (() => void) | null = null;
  controls.addEventListener("start", () => {
    aim = null;
  });
  function narrow(): number {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement ?? canvas;
    return width > 0 ? Math.max(1, height / width) : 1;
  }

  function from(side: Side): void {
    const where: Record<Side, [number, number, number]> = { front: [1.15, -0.95, 0.65], side: [0, -1.7, 0.3], above: [0.01, -0.01, 1.8], hand: [0.45, -0.35, 0.2] };
    const hand = side === "hand" ? [...held.values()][0] : undefined;
    aim = () => from(side);
    controls.target.set(0.35, 0, 0.3);
    scene.updateMatrixWorld(true);
    hand?.getWorldPosition(controls.target);
    camera.position.set(...where[side]).multiplyScalar(narrow()).add(controls.target);
    controls.update();
    draw();
  }

  function fit(): void {
    const around = new Box3().setFromObject(robot.root).expandByObject(things).getBoundingSphere(new Sphere());
    aim = fit;
    controls.target.copy(around.center);
    camera.position.copy(around.center).add(new Vector3(1.15, -0.95, 0.65).normalize().multiplyScalar(Math.max(0.1, 2.75 * around.radius) * narrow()));
    controls.update();
    draw();
  }

  const small = new PerspectiveCamera(40, 1, 0.01, 50);
  small.up.set(0, 0, 1);
  function picture(joints: ReadonlyMap<string, number>, on: HTMLCanvasElement): void {
    robot.stand(joints);
    const around = new Box3().setFromObject(robot.root).getBoundingSphere(new Sphere());
    small.aspect = on.width / on.height;
    small.updateProjectionMatrix();
    small.position.copy(around.center).add(new Vector3(1.15, -0.95, 0.65).normalize().multiplyScalar(Math.max(0.1, 2.5 * around.radius)));
    small.lookAt(around.center);
    const dots = renderer.getPixelRatio();
    ground.visible = false;
    renderer.setViewport(0, 0, on.width / dots, on.height / dots);
    renderer.render(scene, small);
    // In the same breath: what was drawn is gone with the next frame.
    on.getContext("2d")?.drawImage(canvas, 0, canvas.height - on.height, on.width, on.height, 0, 0, on.width, on.height);
    ground.visible = true;
    renderer.setViewport(0, 0, canvas.width / dots, canvas.height / dots);
    robot.stand(stood);
    draw();
  }
  let stood: ReadonlyMap<string, number> = new Map();

  function show(stand: Stand | null, places: readonly Spot[], clouds: readonly NamedCloud[], frames: boolean): void {
    stood = stand?.joints ?? new Map();
    for (const each of axes) each.visible = frames;
    for (const group of [things, ...held.values()]) {
      free(group);
      group.clear();
    }
    for (const trace of stand ? traces.of(stand) : []) things.add(trace);
    traces.glow(stand);
    robot.stand(stood);
    const look = getComputedStyle(canvas);
    for (const [name, item] of Object.entries(stand?.scene ?? {})) {
      const color = new Color(look.getPropertyValue(item.hand ? "--success" : item.fixed ? "--quiet" : "--running").trim());
      const made = makeItem(item, color, stand?.bodies[item.body]);
      made.name = name;
      (held.get(item.hand) ?? things).add(made);
    }
    outline();
    for (const cloud of clouds) {
      const points = makeCloud(cloud, new Color(look.getPropertyValue("--running").trim()));
      (robot.links.get(cloud.frame) ?? things).add(points);
      if (robot.links.has(cloud.frame)) hung.push(points);
    }
    const together = new Map<string, number>();
    for (const { name } of places) together.set(variableOf(name), (together.get(variableOf(name)) ?? 0) + 1);
    for (const each of places) {
      const pose = new Group();
      place(pose, each.at);
      addAxes(pose, AXES, each.over ? FADED : 1);
      if (!each.over && (together.get(variableOf(each.name)) ?? 0) <= NAMED) pose.add(label(each.name, look.getPropertyValue("--text").trim(), look.getPropertyValue("--surface").trim()));
      (robot.links.get(each.frame) ?? things).add(pose);
      if (robot.links.has(each.frame)) hung.push(pose);
    }
    draw();
  }
  const hung: Object3D[] = [];

  /** What is pointed at with the mouse: the thing that would be dragged, or is. */
  let pointed = "";
  function outline(): void {
    const thing = pointed && things.getObjectByName(pointed);
    if (!(thing instanceof Mesh)) return;
    const look = getComputedStyle(canvas);
    const color = new Color(look.getPropertyValue("--accent").trim());
    const edges = new LineSegments(new EdgesGeometry(thing.geometry, 30), new LineBasicMaterial({ color, depthTest: false, transparent: true }));
    edges.renderOrder = 1;
    const name = label(pointed, look.getPropertyValue("--text").trim(), look.getPropertyValue("--surface").trim());
    name.renderOrder = 2;
    (thing.material as MeshStandardMaterial).emissive.copy(color).multiplyScalar(0.3);
    thing.add(edges, name);
  }
  function point(name: string): void {
    if (name === pointed) return;
    const before = pointed && things.getObjectByName(pointed);
    if (before instanceof Mesh) {
      for (const mark of before.children) free(mark);
      before.clear();
      (before.material as MeshStandardMaterial).emissive.set(0);
    }
    pointed = name;
    canvas.dataset.pointed = name;
    outline();
    draw();
  }
  /** What would be taken: the smallest of what is seen there, as others are seen through. */
  function under(ray: Raycaster): Hold | null {
    scene.updateMatrixWorld(true);
    const solid: Mesh[] = [];
    robot.root.traverse((part) => part instanceof Mesh && solid.push(part));
    const hidden = ray.intersectObjects(solid, false)[0]?.distance ?? Infinity;
    const hits = ray.intersectObjects(things.children, false).filter((hit) => hit.object instanceof Mesh && hit.object.name !== "" && hit.distance < hidden);
    const opaque = hits.findIndex((hit) => !((hit.object as Mesh).material as Material).transparent);
    const seen = opaque < 0 ? hits : hits.slice(0, opaque + 1);
    const [least] = seen.sort((one, other) => bulk(one.object as Mesh) - bulk(other.object as Mesh));
    return least ? { name: least.object.name, at: least.point } : null;
  }
  let undrag: (() => void) | null = null;

  dress();
  from("front");
  return {
    show: (stand, places, clouds, frames) => {
      for (const each of hung.splice(0)) {
        free(each);
        each.removeFromParent();
      }
      show(stand, places, clouds, frames);
    },
    grasps: () => {
      scene.updateMatrixWorld(true);
      return new Map([...held].map(([hand, frame]) => [hand, frame.getWorldPosition(new Vector3()).toArray() as [number, number, number]]));
    },
    from,
    fit,
    picture,
    turn: (around, over) => {
      const arm = camera.position.clone().sub(controls.target);
      aim = null;
      arm.applyAxisAngle(camera.up, around * STEP);
      const right = new Vector3().crossVectors(arm, camera.up).normalize();
      const tilted = arm.clone().applyAxisAngle(right, over * STEP);
      if (Math.abs(tilted.clone().normalize().z) < 0.99) arm.copy(tilted);
      camera.position.copy(controls.target).add(arm);
      controls.update();
      draw();
    },
    nearer: (factor) => {
      aim = null;
      camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
      controls.update();
      draw();
    },
    drags: (told) => {
      undrag?.();
      undrag = makeDrag(canvas, camera, under, point, told);
    },
    close: () => {
      cancelAnimationFrame(asked);
      undrag?.();
      sized.disconnect();
      dark.removeEventListener("change", dress);
      controls.dispose();
      renderer.dispose();
    },
  };
}

/** How large the box around a thing is [m³]. */
function bulk({ geometry }: Mesh): number {
  if (geometry.boundingBox === null) geometry.computeBoundingBox();
  const { x, y, z } = (geometry.boundingBox ?? new Box3()).getSize(new Vector3());
  return x * y * z;
}

/** Give back what the graphics card holds of an object and of what hangs on it. */
function free(object: Object3D): void {
  object.traverse((part) => {
    if (part instanceof Mesh || part instanceof Points || part instanceof LineSegments || part instanceof Sprite) {
      part.geometry.dispose();
      for (const material of [part.material].flat() as Material[]) {
        if (material instanceof SpriteMaterial) material.map?.dispose();
        material.dispose();
      }
    }
    if (part instanceof InstancedMesh) part.dispose();
  });
}

function variableOf(name: string): string {
  return name.split(" ")[0] ?? "";
}

function graspFrame(robot: Robot, frame: { link: string; at: number[] }): Group {
  const made = new Group();
  place(made, frame.at);
  (robot.links.get(frame.link) ?? robot.root).add(made);
  return made;
}

function addAxes(parent: Group, size: number, opacity = 1): AxesHelper {
  const axes = new AxesHelper(size);
  if (opacity < 1) Object.assign(axes.material, { transparent: true, opacity });
  parent.add(axes);
  return axes;
}

/** Of a name, at each side, and the size of its letters [px]. */
const PAD = 5;
const LETTERS = 13;

/** A name beside a pose, on a ground of its own. It has the size of other words on the page, however far away it is. */
function label(text: string, color: string, ground: string): Sprite {
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d");
  const font = `600 ${2 * LETTERS}px sans-serif`;
  if (pen) pen.font = font;
  canvas.width = Math.ceil((pen?.measureText(text).width ?? 0) + 4 * PAD);
  canvas.height = 2 * (LETTERS + PAD);
  if (pen) {
    pen.globalAlpha = 0.8;
    pen.fillStyle = ground;
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.globalAlpha = 1;
    pen.font = font;
    pen.textBaseline = "middle";
    pen.fillStyle = color;
    pen.fillText(text, 2 * PAD, canvas.height / 2);
  }
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.center.set(-0.08, 0.5);
  sprite.onBeforeRender = (renderer, _, camera) => {
    const dot = (2 * Math.tan((camera as PerspectiveCamera).fov * (Math.PI / 360))) / Math.max(1, renderer.domElement.clientHeight);
    sprite.scale.set((canvas.width / 2) * dot, (canvas.height / 2) * dot, 1);
    sprite.updateMatrixWorld();
    sprite.modelViewMatrix.multiplyMatrices(camera.matrixWorldInverse, sprite.matrixWorld);
  };
  return sprite;
}
