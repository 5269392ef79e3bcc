//! Results of blows, and penetration of opponents.

use super::{COLOURS, SMOOTH, key, line, plot, smooth, strong_facts};
use crate::panels::colour_of_view;
use crate::panels::paint::section;
use crate::run::{BoutFigures, STEP_HZ, StepFigures};
use crate::stage::bout::{KINDS, colour_of};
use eframe::egui::Ui;

/// Time that hits a minute are counted over, in the plot (s).
const WINDOW_S: f32 = 10.0;

/// Shows the results of blows up to the last of some steps.
pub fn show(ui: &mut Ui, history: &[(u32, &StepFigures)], n: usize) {
    let history: Vec<(u32, BoutFigures)> = history.iter().filter_map(|(s, f)| Some((*s, f.bout?))).collect();
    let Some(&(_, f)) = history.last() else { return };
    section(ui, "Blows", |ui| {
        let share = |count: u32| {
            let percent = 100.0 * f64::from(count) / f64::from(f.blows.thrown.max(1));
            format!("{count} ({percent:.0} %)")
        };
        strong_facts(ui, "blows", |row| {
            row("thrown", f.blows.thrown.to_string());
            row("landed", share(f.blows.landed));
            if f.penetration_m.is_some() {
                row("blocked", share(f.blows.blocked));
            }
            row("missed", share(f.blows.missed));
            let since = BoutFigures::default();
            row("hits a minute", format!("{:.1} a character", f.hits_per_minute(&since, n)));
            if let Some(now) = f.penetration_m {
                let most = f.max_penetration_m;
                row("penetration", format!("{:.1} cm now, {:.1} cm at most", 100.0 * now, 100.0 * most));
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.weak("marks:");
            for (met, name) in KINDS {
                match colour_of(met) {
                    Some(colour) => key(ui, name, colour_of_view(colour)),
                    None => _ = ui.label(name),
                }
            }
        });
        key(ui, &format!("hits a minute and character, over {WINDOW_S:.0} s"), COLOURS[1]);
        let (steps, values) = (history.iter().map(|h| h.0), windowed(&history, n));
        plot("hits", "").show(ui, |p| p.line(line("hits a minute", COLOURS[1], smooth(steps, &values))));
        if f.penetration_m.is_some() {
            penetration(ui, &history);
        }
    });
}

/// Hits a minute over the last [`WINDOW_S`], or since the start where that is less, at every step.
fn windowed(history: &[(u32, BoutFigures)], characters: usize) -> Vec<f64> {
    let window = (WINDOW_S * STEP_HZ) as u32;
    let mut first = 0;
    let at = |(step, f): &(u32, BoutFigures)| {
        while history[first].0 + window < *step {
            first += 1;
        }
        f.hits_per_minute(&history[first].1, characters)
    };
    history.iter().map(at).collect()
}

fn penetration(ui: &mut Ui, history: &[(u32, BoutFigures)]) {
    key(ui, "deepest penetration", COLOURS[3]);
    // Peaks, which a mean would hide.
    let peaks = history.chunks(SMOOTH).flat_map(|c| {
        let most = c.iter().filter_map(|h| h.1.penetration_m).fold(0.0, f32::max);
        c.iter().map(move |_| 100.0 * f64::from(most))
    });
    let values: Vec<f64> = peaks.collect();
    let steps = history.iter().map(|h| h.0);
    plot("penetration", "cm").show(ui, |p| p.line(line("penetration", COLOURS[3], smooth(steps, &values))));
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_simulation::sparring::BlowTally;

    #[test]
    fn hits_a_minute_are_those_of_the_window() {
        // Two characters, one hit a second for 30 s, then none.
        let at = |step: u32| {
            let seconds = f64::from(step) / 60.0;
            let landed = (seconds as u32).min(30);
            (
                step,
                BoutFigures { blows: BlowTally { landed, ..BlowTally::default() }, seconds, ..BoutFigures::default() },
            )
        };
        let history: Vec<_> = (0..=3600).map(at).collect();
        let rates = windowed(&history, 2);
        assert!((rates[1500] - 30.0).abs() < 2.0, "{}", rates[1500]);
        assert!(rates[3600] == 0.0 && (rates[2100] - 15.0).abs() < 2.0, "{}", rates[2100]);
        assert_eq!(rates[0], 0.0);
    }
}
