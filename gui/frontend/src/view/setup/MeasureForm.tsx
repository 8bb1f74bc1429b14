/** Keep where the robot is now: its joints or its pose, measured, become a named message of the project. */
import { type JSX, useEffect, useState } from "react";

import { server } from "../../protocol/client";
import type { MeasureWish, RobotParts } from "../../protocol/generated";
import { messageOf, useLive, wished } from "../../store/live";

const ROBOTS: readonly [MeasureWish["robot"], string][] = [
  ["run", "the run under way"],
  ["ros", "the real robot (ROS)"],
  ["sim", "a fresh simulation"],
  ["fake", "the fake"],
];

export function MeasureForm(): JSX.Element {
  const [parts, setParts] = useState<RobotParts | null>(null);
  const [robot, setRobot] = useState<MeasureWish["robot"] | "">("");
  const [part, setPart] = useState("");
  const [what, setWhat] = useState<MeasureWish["what"]>("joints");
  const [name, setName] = useState("");
  const [serve, setServe] = useState(true);
  const [busy, setBusy] = useState(false);
  const served = useLive((s) => s.messages?.served === true);
  useEffect(() => {
    let left = false;
    server.robotParts().then(
      (found) => left || setParts(found),
      (error: unknown) => left || setParts({ robot: "", arms: [], hands: [], run: "", trouble: messageOf(error) }),
    );
    return () => {
      left = true;
    };
  }, []);
  const all = [...(parts?.arms ?? []), ...(parts?.hands ?? [])];
  const whose = robot || (parts?.run ? "run" : "sim");
  const chosen = part || all[0] || "";
  const hand = parts?.hands.includes(chosen) === true;
  async function measure(): Promise<void> {
    setBusy(true);
    await wished(() => server.measure({ robot: whose, part: chosen, what: hand ? "joints" : what, name: name.trim(), serve: served && serve }));
    setBusy(false);
  }
  return (
    <fieldset aria-label="Where the robot is">
      <legend>Keep where the robot is</legend>
      {parts !== null && all.length === 0 ? (
        <p className="hint">{parts.trouble || "grip.yaml names no arm and no hand yet."}</p>
      ) : (
        <>
          <div className="form-field">
            <label htmlFor="measure-robot">Measured at</label>
            <select id="measure-robot" value={whose} onChange={(event) => setRobot(event.target.value as MeasureWish["robot"])}>
              {ROBOTS.filter(([each]) => each !== "run" || parts?.run).map(([each, label]) => (
                <option key={each} value={each}>
                  {label}
                </option>
              ))}
            </select>
          </div>
          <div className="form-field">
            <label htmlFor="measure-part">Arm or hand</label>
            <select id="measure-part" value={chosen} onChange={(event) => setPart(event.target.value)}>
              {all.map((each) => (
                <option key={each}>{each}</option>
              ))}
            </select>
          </div>
          <div className="form-field">
            <label htmlFor="measure-what">What</label>
            <select id="measure-what" value={hand ? "joints" : what} disabled={hand} onChange={(event) => setWhat(event.target.value as MeasureWish["what"])}>
              <option value="joints">its joints</option>
              <option value="pose">the pose of its grasp frame</option>
            </select>
          </div>
          <div className="form-field">
            <label htmlFor="measure-name">Name</label>
            <input id="measure-name" type="text" value={name} placeholder="above_table" onChange={(event) => setName(event.target.value)} />
          </div>
          {served && (
            <div className="form-field">
              <label htmlFor="measure-serve">To the server too</label>
              <input id="measure-serve" type="checkbox" checked={serve} onChange={(event) => setServe(event.target.checked)} />
            </div>
          )}
          <button disabled={busy || name.trim() === ""} onClick={() => void measure()}>
            {busy ? "Measuring ..." : "Measure and keep"}
          </button>
        </>
      )}
    </fieldset>
  );
}
