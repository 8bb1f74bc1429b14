/** The topics of the running ROS graph: receive one message and look at it, or make a sensor of it. */
import { type JSX, useEffect, useState } from "react";
import { cameraOf, type CameraTopics } from "../../model/parts";
import { server } from "../../protocol/client";
import { type Shape, shapeAt, valueAt } from "../../model/shapes";
import type { ReceivedView, SetupView, TopicView } from "../../protocol/generated";
import { lookAtTopics, messageOf, useAsCamera, useAsSensor, useLive } from "../../store/live";
import { ValueShown } from "../SidePanel";
import { WorldPicture } from "./ProjectParts";
import { Value } from "./SchemaForm";

const PERIOD = 3000;
const NONE: readonly TopicView[] = [];

export function TopicsPage({ done }: { done: () => void }): JSX.Element {
  const found = useLive((s) => s.topics);
  const looking = useLive((s) => s.looking);
  const [name, setName] = useState("");
  const [filter, setFilter] = useState("");
  useEffect(() => {
    void lookAtTopics();
    const timer = setInterval(() => document.visibilityState === "visible" && void lookAtTopics(), PERIOD);
    return () => clearInterval(timer);
  }, []);
  const shown = (found?.topics ?? []).filter((topic) => `${topic.name} ${topic.type}`.toLowerCase().includes(filter.toLowerCase()));
  const chosen = found?.topics.find((topic) => topic.name === name);
  return (
    <section className="live" aria-labelledby="topics-title">
      <div className="live-list">
        <h3 id="topics-title">Published topics</h3>
        {found?.error ? (
          <p className="fault" role="alert">
            {found.error}
          </p>
        ) : (
          <p className="hint" role="status">
            {found === null ? "Looking at the ROS graph ..." : `${found.topics.length} in ROS domain ${found.domain}; looked at every 3 s`}
          </p>
        )}
        <p className="live-bar">
          <input type="text" aria-label="Filter topics" placeholder="Filter by name or type" value={filter} onChange={(event) => setFilter(event.target.value)} />
          <button disabled={looking} onClick={() => void lookAtTopics()}>
            Look again
          </button>
        </p>
        {found !== null && found.error === "" && found.topics.length === 0 && (
          <p className="hint">No topics are published. Start the sensor's driver in a shell with the same ROS_DOMAIN_ID, or with `grip launch`.</p>
        )}
        <ul className="plain" aria-label="Topics">
          {shown.map((topic) => (
            <li key={topic.name}>
              <button className="setup-file" aria-pressed={topic.name === name} onClick={() => setName(topic.name)}>
                {topic.name}
                <code>{topic.type}</code>
              </button>
            </li>
          ))}
        </ul>
      </div>
      {chosen ? <Topic key={chosen.name} topic={chosen} done={done} /> : <p className="hint live-detail">Choose a topic to receive a message of it.</p>}
    </section>
  );
}

/** What each sensor sees: the camera of the simulated world, and the topics of the real one, again and again. */
export function SensorsPage({ view }: { view: SetupView }): JSX.Element {
  const sensors = Object.keys((valueAt(view.data, ["sensors"]) as object | null | undefined) ?? {});
  const topics = useLive((s) => s.topics);
  const world = valueAt(view.data, ["world"]);
  const named = sensors.flatMap((sensor) => topicsOf(view.data, sensor));
  useEffect(() => {
    if (named.length > 0) void lookAtTopics();
  }, [named.length]);
  if (sensors.length === 0) return <p className="hint">The project has no sensor yet. Topics, on the left, makes one of what is published.</p>;
  return (
    <div className="setup-cards">
      {sensors.map((sensor) => {
        const camera = valueAt(view.data, ["sensors", sensor, "camera"]);
        const heard = topicsOf(view.data, sensor);
        return (
          <fieldset key={sensor} aria-label={`Sensor ${sensor}`}>
            <legend>
              {sensor} <span className="hint">{typeof camera === "string" && `camera ${camera} of the world ${String(world ?? "")}`}</span>
            </legend>
            {typeof camera === "string" && typeof world === "string" && <WorldPicture name={world} cameras={[camera]} />}
            {heard.map((name) => {
              const topic = topics?.topics.find((each) => each.name === name);
              return topic ? <Received key={name} topic={topic} /> : <p key={name} className="hint">{name}: {topics === null ? "looking at the ROS graph ..." : "nobody publishes it now"}</p>;
            })}
            {heard.length === 0 && typeof camera !== "string" && <p className="hint">It says neither a camera of the world nor topics.</p>}
            <Value view={view} place={["sensors", sensor]} shape={shapeAt(view.shape as Shape, ["sensors", "?"])} bare />
          </fieldset>
        );
      })}
    </div>
  );
}

/** The topics of a sensor: of its outputs, and of the camera that it is on the real robot. */
function topicsOf(data: unknown, sensor: string): string[] {
  const outputs = Object.values((valueAt(data, ["sensors", sensor, "topics"]) as Record<string, { topic?: string }> | undefined) ?? {}).map((output) => output?.topic);
  const camera = valueAt(data, ["ros", "cameras", sensor]) as { color?: string; depth?: string } | undefined;
  return [...outputs, camera?.color, camera?.depth].filter((name): name is string => typeof name === "string");
}

/** Messages of a topic: one, or one after the other for as long as one looks. */
function Received({ topic }: { topic: TopicView }): JSX.Element {
  const [received, setReceived] = useState<ReceivedView | null>(null);
  const [busy, setBusy] = useState(false);
  const [live, setLive] = useState(false);
  async function receive(): Promise<void> {
    setBusy(true);
    try {
      setReceived(await server.receive({ topic: topic.name, type: topic.type, within: 5 }));
    } catch (error) {
      setReceived({ value: null, seconds: 0, error: messageOf(error) });
      setLive(false);
    } finally {
      setBusy(false);
    }
  }
  useEffect(() => {
    if (live && !busy && document.visibilityState === "visible") void receive();
  }, [live, busy]);
  return (
    <>
      <p>
        <button className="main" disabled={busy && !live} onClick={() => void receive()}>
          {busy && !live ? "Waiting for it ..." : "Receive one message"}
        </button>{" "}
        <label className="robot-frames">
          <input type="checkbox" checked={live} onChange={(event) => setLive(event.target.checked)} /> Live
        </label>
      </p>
      <div role={live ? "group" : "status"} aria-label="Received message">
        {received?.error && <p className="fault">{received.error}</p>}
        {received?.value && (
          <>
            <p className="hint">{live ? `${topic.name}, live` : `came after ${received.seconds.toFixed(2)} s`}</p>
            <ValueShown view={received.value} name={topic.name} />
          </>
        )}
      </div>
    </>
  );
}

function Topic({ topic, done }: { topic: TopicView; done: () => void }): JSX.Element {
  const [sensor, setSensor] = useState("");
  const [output, setOutput] = useState("");
  const topics = useLive((s) => s.topics?.topics ?? NONE);
  const camera = cameraOf(topic, topics);
  const word = topic.name.split("/").filter(Boolean).at(-1)?.toLowerCase() ?? "value";
  return (
    <div className="live-detail" role="group" aria-label={`Topic ${topic.name}`}>
      <h4>{topic.name}</h4>
      <p className="hint">
        {topic.type}, {topic.publishers} {topic.publishers === 1 ? "publisher" : "publishers"}; a task gets a <code>{topic.value}</code>
      </p>
      <Received topic={topic} />
      {camera && <CameraForm camera={camera} suggested={topic.name.split("/")[1] ?? ""} done={done} />}
      <fieldset>
        <legend>Use as a sensor</legend>
        <div className="form-field">
          <label htmlFor="sensor-name">Sensor</label>
          <input id="sensor-name" type="text" value={sensor} placeholder="depth_camera" onChange={(event) => setSensor(event.target.value)} />
        </div>
        <div className="form-field">
          <label htmlFor="sensor-output">Output</label>
          <input id="sensor-output" type="text" value={output} placeholder={word} onChange={(event) => setOutput(event.target.value)} />
        </div>
        <button
          onClick={() => {
            done();
            void useAsSensor(topic, sensor.trim() || "depth_camera", output.trim() || word);
          }}
        >
          Put it into grip.yaml
        </button>
      </fieldset>
    </div>
  );
}

/** A camera that tasks ask by name: in the simulated world, and by these topics on the real robot. */
function CameraForm({ camera, suggested, done }: { camera: CameraTopics; suggested: string; done: () => void }): JSX.Element {
  const [name, setName] = useState("");
  return (
    <fieldset>
      <legend>Use as a camera of the real robot</legend>
      <dl className="live-camera">
        {Object.entries(camera).map(([part, topic]) => (
          <div key={part}>
            <dt>{part}</dt>
            <dd>{topic ? <code>{topic}</code> : <span className="hint">not found; to be filled in</span>}</dd>
          </div>
        ))}
      </dl>
      <div className="form-field">
        <label htmlFor="camera-name">Camera</label>
        <input id="camera-name" type="text" value={name} placeholder={suggested} onChange={(event) => setName(event.target.value)} />
      </div>
      <button
        onClick={() => {
          done();
          void useAsCamera(camera, name.trim() || suggested);
        }}
      >
        Put the camera into grip.yaml
      </button>
    </fieldset>
  );
}
