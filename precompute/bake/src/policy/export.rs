//! A policy as CSV, for external checks.

use std::io::{self, Write};
use throng_core::policy::PolicyTable;

/// Writes one row per state and cell: the cell's centre, the value, the best action.
///
/// Header `state,cell,angle_rad,distance_m,height_m,x_m,z_m,value,best_action`; x is to the left, z ahead; the action
/// is an index within the state's actions. In an adaptive policy cells are those of the state's own grid.
///
/// # Errors
/// Errors of `out`.
pub fn write_csv(policy: &PolicyTable, mut out: impl Write) -> io::Result<()> {
    writeln!(out, "state,cell,angle_rad,distance_m,height_m,x_m,z_m,value,best_action")?;
    for state in 0..policy.actions().num_states() as u32 {
        let grid = policy.grid_of(state);
        for (cell, value) in policy.values_of(state).iter().enumerate() {
            let (c, p) = (grid.cell_coordinates(cell), grid.cell_centre(cell) + policy.centre());
            let best = policy.best_of(state, cell)[0];
            writeln!(out, "{state},{cell},{},{},{},{},{},{value},{best}", c.x, c.y, c.z, p.x, p.z)?;
        }
    }
    Ok(())
}
