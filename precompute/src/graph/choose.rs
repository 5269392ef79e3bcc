//! Which of the possible transitions become actions: near ones, with different outcomes, and enough of them.

use super::config::GraphConfig;
use super::matches::Link;
use throng_runtime::Planar;
use throng_runtime::planar::wrap_angle;

/// Matches every event frame may use beyond the threshold, in and out.
const NEAREST: usize = 2;

/// The links of every event at a threshold, best first; at most `max_actions - 1` each.
///
/// - `matches`: all links up to `max_error`, best first.
/// - `outcomes`: where the motion after each event leads.
///
/// First come the nearest matches, of this event and of those that have this one as nearest, which may exceed
/// the threshold; then the rest up to the threshold, each unless a better one has the same outcome.
pub(super) fn choose(
    matches: &[Vec<Link>],
    outcomes: &[Planar],
    threshold: f32,
    config: &GraphConfig,
) -> Vec<Vec<Link>> {
    let mut chosen: Vec<Vec<Link>> = vec![Vec::new(); matches.len()];
    for (i, links) in matches.iter().enumerate() {
        for link in links.iter().take(NEAREST) {
            chosen[i].push(*link);
            // The way in: the same pair the other way round, where that is possible.
            if let Some(back) = matches[link.event].iter().find(|l| l.event == i) {
                chosen[link.event].push(*back);
            }
        }
    }
    for (links, all) in chosen.iter_mut().zip(matches) {
        sort(links);
        links.dedup_by_key(|l| l.event);
        links.truncate(config.max_actions - 1);
        for link in all.iter().take_while(|l| l.error <= threshold) {
            if links.len() + 1 >= config.max_actions {
                break;
            }
            let same =
                |l: &Link| l.event == link.event || same_outcome(&outcomes[l.event], &outcomes[link.event], config);
            if !links.iter().any(same) {
                links.push(*link);
            }
        }
        sort(links);
    }
    chosen
}

fn sort(links: &mut [Link]) {
    links.sort_unstable_by(|a, b| a.error.total_cmp(&b.error).then(a.event.cmp(&b.event)));
}

fn same_outcome(a: &Planar, b: &Planar, config: &GraphConfig) -> bool {
    f64::from((a.x - b.x).hypot(a.z - b.z)) < config.outcome_distance
        && f64::from(wrap_angle(a.heading - b.heading).abs()) < config.outcome_angle
}

#[cfg(test)]
mod tests {
    use super::*;

    fn links(errors: &[(usize, f32)]) -> Vec<Link> {
        errors.iter().map(|&(event, error)| Link { event, error }).collect()
    }

    fn events(links: &[Link]) -> Vec<usize> {
        links.iter().map(|l| l.event).collect()
    }

    #[test]
    fn of_equal_outcomes_the_better_stays_and_the_nearest_two_always() {
        let mut matches = vec![Vec::new(); 6];
        matches[0] = links(&[(1, 0.1), (2, 0.2), (3, 0.3), (4, 0.4), (5, 0.9)]);
        let z = [0.0, 1.0, 1.0, 1.02, 2.0, 3.0];
        let outcomes = z.map(|z| Planar::new(0.0, z, 0.0));
        let chosen = choose(&matches, &outcomes, 0.5, &GraphConfig::default());
        assert_eq!(events(&chosen[0]), [1, 2, 4]);
    }

    #[test]
    fn a_rare_event_is_entered_and_left_beyond_the_threshold() {
        let mut matches = vec![Vec::new(); 4];
        matches[0] = links(&[(1, 0.1), (2, 0.1), (3, 0.6)]);
        matches[3] = links(&[(0, 0.6)]);
        let outcomes = [Planar::IDENTITY; 4];
        let chosen = choose(&matches, &outcomes, 0.5, &GraphConfig::default());
        assert_eq!(events(&chosen[0]), [1, 2, 3]);
        assert_eq!(events(&chosen[3]), [0]);
    }

    #[test]
    fn never_more_than_the_most_actions() {
        let mut matches = vec![Vec::new(); 100];
        matches[0] = (1..100).map(|event| Link { event, error: 0.1 }).collect();
        let outcomes: Vec<Planar> = (0..100).map(|z| Planar::new(0.0, z as f32, 0.0)).collect();
        let chosen = choose(&matches, &outcomes, 0.5, &GraphConfig { max_actions: 10, ..Default::default() });
        assert_eq!(chosen[0].len(), 9);
    }
}
