import { follow_clock } from "./charts.js";
import { Clock } from "./clock.js";
import { show_curves } from "./curves.js";
import { section } from "./dom.js";
import { show_motion } from "./player.js";
import { show_certificate, show_problem, show_provenance, show_search, show_verdict } from "./tables.js";

const { runs } = JSON.parse(section("data").textContent);
const clock = new Clock(Math.max(...runs.map(({ frames }) => frames.time[frames.time.length - 1])));
section("verdict").replaceChildren();
show_verdict(runs);
show_certificate(runs);
show_search(runs);
show_problem(runs);
show_provenance(runs);
show_motion(runs, clock);
show_curves(runs, clock);
follow_clock(clock);
clock.set(0.4 * clock.duration);
