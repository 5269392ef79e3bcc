//! Figures of scenes, for people.

use crate::{args::CommandResult, output};
use throng_precompute::run::SceneFigures;

/// Prints what was measured of a scene or a group, below a line about it.
pub fn print_figures(label: &'static str, text: String, r: &SceneFigures) -> CommandResult {
    let mut rows = vec![(label, text)];
    if let Some(b) = &r.blows {
        let [landed, blocked] = [b.landed_fraction, b.blocked_fraction].map(|fraction| 100.0 * fraction);
        let thrown = format!("{} thrown: {landed:.1} % landed, {blocked:.1} % blocked", b.thrown);
        rows.push(("blows", format!("{thrown}; {:.1} landed a minute and character", b.hits_per_minute)));
        let most = b.distance_max_m.map_or(String::new(), |m| format!(", {m:.2} m at most after 5 s"));
        rows.push(("distance", format!("{:.2} m from the target on average{most}", b.distance_mean_m)));
        let deep = 100.0 * b.deep_fraction;
        rows.push(("penetration", format!("{:.3} m at most, deep {deep:.2} % of the time", b.max_penetration_m)));
    }
    if let Some(t) = &r.touch {
        let [bodies, heads] = [t.arms_in_bodies_per_minute, t.wrists_in_heads_per_minute];
        rows.push(("arms", format!("{bodies:.1} in bodies, {heads:.1} in heads, times a minute and boxer")));
        let [apart, close] = [t.head_distance_mean_m, 100.0 * t.heads_close_fraction];
        rows.push(("heads", format!("{apart:.2} m apart, closer than 0.45 m {close:.1} % of the time")));
    }
    if let (Some(pairs), Some(deepest_m)) = (r.character_overlaps, r.deepest_overlap_m) {
        rows.push(("overlaps", format!("{pairs} pair(s), {deepest_m:.2} m at most")));
    }
    if let Some(w) = &r.world {
        let (times, deepest_m) = (w.environment_penetrations, w.deepest_penetration_m);
        rows.push(("surroundings", format!("{times} time(s) in a unit, {deepest_m:.2} m at most")));
        let goals = format!("{:.2} fulfilled and {:.0} m travelled", w.fulfilled_per_minute, w.travelled_m_per_minute);
        let waiting = 100.0 * w.waiting_fraction;
        let turned = format!("turning {:.0} deg a metre", w.turned_deg_per_m);
        rows.push(("goals", format!("{goals} a minute and character, {turned}; waiting {waiting:.1} % of the time")));
    }
    if let Some(p) = &r.partners {
        let ends = format!("{} finished, {} broken off", p.pairs_finished, p.pairs_broken_off);
        rows.push(("pairs", format!("{} begun, {ends}; {} did not come together", p.pairs_begun, p.pairs_given_up)));
        let apart = |off_m: f64, turned_deg: f64| format!("{:.0} mm and {turned_deg:.1} deg", 1e3 * off_m);
        let p95 = apart(p.partner_off_p95_m, p.partner_turned_p95_deg);
        let most = apart(p.partner_off_max_m, p.partner_turned_max_deg);
        let waited = format!("waited {:.1} s on average", p.partner_wait_mean_s);
        rows.push(("partners", format!("{p95} off the capture (95th percentile), {most} at most; {waited}")));
    }
    if let Some(p) = &r.paths {
        rows.push(("paths", format!("{:.2} m/s on average, {:.2} at most", p.speed_mean_mps, p.speed_max_mps)));
        rows.push(("knees", format!("{:.1} rad/s at most", p.knee_rate_max_radps)));
    }
    if let Some(t) = &r.travel {
        let stuck = format!("{} stuck at the end", t.stuck_at_end);
        rows.push(("progress", format!("{:.2} m/s towards the goal; {} there; {stuck}", t.progress_mps, t.arrived)));
    }
    if let Some(c) = &r.crowd {
        let engine = r.engine.as_deref().unwrap_or_default();
        let wanted = format!("{:.2} m/s towards the goal of {:.2} wanted", c.progress_mps, c.desired_mps);
        rows.push(("progress", format!("{wanted}; {} there; engine {engine}", c.arrived)));
        let [mm, cm] = [c.overlap_over_1mm_fraction, c.overlap_over_1cm_fraction].map(|f| 100.0 * f);
        let frames = format!("{mm:.3} % of agent-frames by more than 1 mm, {cm:.3} % by more than 1 cm");
        rows.push(("overlaps", format!("{frames}; {:.2} mm at most", 1000.0 * c.max_overlap_m)));
        let lanes = |order| ("lanes", format!("order {order:.2}: 0 as mixed as by chance, 1 all in lanes"));
        rows.extend(c.lane_order.map(lanes));
        if let Some(flow) = &c.flow {
            let [low, high] = flow.human_flow_per_m_s;
            let few = || "too few for a flow".to_owned();
            let measured = flow.flow_per_m_s.map_or_else(few, |f| format!("{f:.2} persons/(m s)"));
            rows.push(("gate", format!("{} crossed, {measured}; people: {low} to {high}", flow.crossed)));
        }
        if let Some(t) = &c.things {
            let [p95, most] = [t.hand_off_p95_m, t.hand_off_max_m].map(|m| 1e3 * m);
            let missed = match t.things_out_of_reach {
                0 => String::new(),
                n => format!(", {n} times out of reach"),
            };
            let moved = format!("{} taken, {} put down{missed}", t.things_taken, t.things_put);
            rows.push(("things", format!("{moved}; palms off by {p95:.0} mm (95 %), {most:.0} mm at worst")));
        }
        rows.extend(c.informed.map(|informed| ("news", format!("{informed} know"))));
        if let (Some(us), Some(events)) = (c.us_per_agent_second, c.events_per_agent_second) {
            let crossings = |c| format!(" ({c:.1} of them crossings of cells)");
            let crossings = c.crossings_per_agent_second.map_or(String::new(), crossings);
            let decisions = c.decisions_per_agent_second.unwrap_or_default();
            let cost = format!("{us:.2} us an agent and simulated second");
            rows.push(("speed", format!("{cost}; {events:.1} events{crossings}, {decisions:.1} decisions")));
        }
        rows.extend(c.hips_off_max_m.map(|off| ("bodies", format!("hips {off:.2} m off their discs at most"))));
    }
    rows.extend(r.stuck.map(|stuck| ("stuck", stuck.to_string())));
    if let (Some(mean), Some(p95)) = (r.foot_slip_mean_mps, r.foot_slip_p95_mps) {
        rows.push(("foot slip", format!("{mean:.3} m/s mean, {p95:.3} m/s 95th percentile, while planted")));
    }
    let speed = |rate| ("speed", format!("{rate:.0} steps a second of all characters, on one thread"));
    rows.extend(r.steps_per_second.map(speed));
    output::table(&rows)
}
