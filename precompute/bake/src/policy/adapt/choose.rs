//! Assignment of grids to states: cells go where they lower the error most.

/// Costs and errors from which a shape is chosen for each state.
#[derive(Clone, Copy)]
pub(super) struct ShapeChoices<'a> {
    /// Cells of each shape.
    pub cells: &'a [usize],
    /// Sum of squared errors of each (state, shape), states one after the other.
    pub errors: &'a [f64],
    /// Weight of the errors of each state (> 0).
    pub weights: &'a [f64],
    /// Most cells of all states together.
    pub budget: usize,
    /// Sum of squared errors below which a state gets no more cells.
    pub enough: f64,
}

/// A worthwhile refinement of a state.
struct ShapeRefinement {
    state: usize,
    shape: usize,
    cells: usize,
    /// Weighted error removed per added cell.
    gain: f64,
}

impl ShapeChoices<'_> {
    /// A shape for every state; fails with the number of cells of the coarsest shapes if that exceeds the budget.
    ///
    /// Every state starts with the fewest cells. Of all refinements on the lower hull of a state's errors over its
    /// cells, the one that removes most weighted error per cell comes first, until one does not fit. No other choice
    /// with at most that many cells has less weighted error.
    pub fn choose(&self) -> Result<Vec<usize>, usize> {
        let hulls: Vec<Vec<usize>> = self.errors.chunks_exact(self.cells.len()).map(|e| self.hull(e)).collect();
        let mut chosen: Vec<usize> = hulls.iter().map(|h| h[0]).collect();
        let mut used: usize = chosen.iter().map(|&k| self.cells[k]).sum();
        if used > self.budget {
            return Err(used);
        }
        let mut steps: Vec<ShapeRefinement> =
            hulls.iter().enumerate().flat_map(|(s, hull)| self.steps(s, hull)).collect();
        // Stable, so that a state's own steps stay in order.
        steps.sort_by(|a, b| b.gain.total_cmp(&a.gain).then(a.state.cmp(&b.state)));
        for step in steps {
            used += step.cells;
            if used > self.budget {
                break;
            }
            chosen[step.state] = step.shape;
        }
        Ok(chosen)
    }

    fn steps(&self, state: usize, hull: &[usize]) -> Vec<ShapeRefinement> {
        let error = |shape: usize| self.errors[state * self.cells.len() + shape];
        let step = |pair: &[usize]| {
            let cells = self.cells[pair[1]] - self.cells[pair[0]];
            let gain = self.weights[state] * (error(pair[0]) - error(pair[1])) / cells as f64;
            ShapeRefinement { state, shape: pair[1], cells, gain }
        };
        hull.windows(2).take_while(|pair| error(pair[0]) > self.enough).map(step).collect()
    }

    /// Shapes from the fewest cells to the least error, such that each step gains less per cell than the one before.
    fn hull(&self, errors: &[f64]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..errors.len()).collect();
        order.sort_by(|&a, &b| self.cells[a].cmp(&self.cells[b]).then(errors[a].total_cmp(&errors[b])).then(a.cmp(&b)));
        let mut hull: Vec<usize> = Vec::new();
        let gain = |a: usize, b: usize| (errors[a] - errors[b]) / (self.cells[b] - self.cells[a]) as f64;
        for shape in order {
            // No better than a shape with as many cells or fewer.
            if hull.last().is_some_and(|&last| errors[shape] >= errors[last]) {
                continue;
            }
            while let [.., a, b] = hull[..] {
                if gain(a, b) > gain(b, shape) {
                    break;
                }
                hull.pop();
            }
            hull.push(shape);
        }
        hull
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Cells and weighted error of a choice.
    fn total(c: &ShapeChoices<'_>, chosen: &[usize]) -> (usize, f64) {
        let error = |(s, &k): (usize, &usize)| c.weights[s] * c.errors[s * c.cells.len() + k];
        (chosen.iter().map(|&k| c.cells[k]).sum(), chosen.iter().enumerate().map(error).sum())
    }

    #[test]
    fn cells_go_to_the_state_that_gains_most() {
        // State 0 gains 9 from three cells more, state 1 only 2.
        let errors = [0.0, 9.0, 0.0, 2.0];
        let c = ShapeChoices { cells: &[4, 1], errors: &errors, weights: &[1.0, 1.0], budget: 5, enough: 0.0 };
        assert_eq!(c.choose(), Ok(vec![0, 1]));
        assert_eq!(ShapeChoices { weights: &[1.0, 5.0], ..c }.choose(), Ok(vec![1, 0]), "2 counts more than 9");
        assert_eq!(ShapeChoices { budget: 8, ..c }.choose(), Ok(vec![0, 0]));
        assert_eq!(
            ShapeChoices { budget: 8, enough: 3.0, ..c }.choose(),
            Ok(vec![0, 1]),
            "an error of 2 is small enough"
        );
        assert_eq!(ShapeChoices { budget: 1, ..c }.choose(), Err(2));
    }

    proptest! {
        #[test]
        fn with_as_many_cells_no_choice_is_better(
            errors in prop::collection::vec(0u32..50, 3 * 4), cells in prop::array::uniform4(1usize..9),
            weights in prop::array::uniform3(1u32..4), budget in 0usize..40,
        ) {
            let errors: Vec<f64> = errors.into_iter().map(f64::from).collect();
            let weights = weights.map(f64::from);
            let c = ShapeChoices { cells: &cells, errors: &errors, weights: &weights, budget, enough: 0.0 };
            let least = 3 * cells.iter().min().unwrap();
            match c.choose() {
                Err(needed) => prop_assert!(needed == least && least > budget),
                Ok(chosen) => {
                    let (used, error) = total(&c, &chosen);
                    prop_assert!(used <= budget);
                    for other in (0..64usize).map(|k| [k % 4, k / 4 % 4, k / 16]) {
                        let (cells, left) = total(&c, &other);
                        prop_assert!(cells > used || left >= error - 1e-9, "{:?} instead of {:?}", other, chosen);
                    }
                }
            }
        }
    }
}
