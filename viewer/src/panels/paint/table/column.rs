//! Columns: which of them fit, and their positions.

use std::ops::Range;

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct TableColumn<'a> {
    /// Title above the column.
    pub title: &'a str,
    /// Meaning of the column.
    pub hint: &'a str,
    /// Least width (points).
    pub width: f32,
    /// Share of the width that is left over.
    pub grows: f32,
    /// Numbers stand at the right.
    pub is_number: bool,
    /// Rank for leaving columns out: if there is no room for all, the largest rank goes first, and of equal ranks the
    /// last column; columns of rank 0 always stay.
    pub spare: u8,
}

impl<'a> TableColumn<'a> {
    /// A column of texts that takes its share of the width that is left over.
    pub const fn text(title: &'a str, hint: &'a str, width: f32, grows: f32) -> Self {
        Self { title, hint, width, grows, is_number: false, spare: 0 }
    }

    /// A column of numbers.
    pub const fn number(title: &'a str, hint: &'a str, width: f32) -> Self {
        Self { title, hint, width, grows: 0.0, is_number: true, spare: 0 }
    }

    /// This column with a rank for leaving it out; see [`TableColumn::spare`].
    pub const fn spare(self, rank: u8) -> Self {
        Self { spare: rank, ..self }
    }
}

/// Least width of a table that has all of the columns (points).
pub fn least_width(columns: &[TableColumn<'_>]) -> f32 {
    columns.iter().map(|c| c.width).sum()
}

/// A visible column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ColumnPlace {
    /// Number of the column.
    pub column: usize,
    /// From where to where it goes, from the left edge of a row on (points).
    pub x: Range<f32>,
}

/// Positions of the visible columns.
pub(super) fn places(columns: &[TableColumn<'_>], width: f32) -> Vec<ColumnPlace> {
    let kept = fitting(columns, width);
    let least: f32 = kept.iter().map(|&c| columns[c].width).sum();
    let shares: f32 = kept.iter().map(|&c| columns[c].grows).sum();
    let rest = if shares > 0.0 { (width - least).max(0.0) / shares } else { 0.0 };
    let mut x = 0.0;
    let place = |column: usize| {
        let from = x;
        x += columns[column].width + columns[column].grows * rest;
        ColumnPlace { column, x: from..x }
    };
    kept.into_iter().map(place).collect()
}

/// Numbers of the columns that fit.
fn fitting(columns: &[TableColumn<'_>], width: f32) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..columns.len()).collect();
    while kept.iter().map(|&c| columns[c].width).sum::<f32>() > width {
        let most = kept.iter().map(|&c| columns[c].spare).max().unwrap_or(0);
        let Some(at) = kept.iter().rposition(|&c| most > 0 && columns[c].spare == most) else { break };
        kept.remove(at);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(width: f32, grows: f32) -> TableColumn<'static> {
        TableColumn::text("", "", width, grows)
    }

    fn ranges(columns: &[TableColumn<'_>], width: f32) -> Vec<Range<f32>> {
        places(columns, width).into_iter().map(|p| p.x).collect()
    }

    #[test]
    fn columns_share_what_is_left_over_and_keep_their_least_width() {
        let columns = [column(50.0, 1.0), column(30.0, 0.0), column(20.0, 3.0)];
        assert_eq!(ranges(&columns, 140.0), [0.0..60.0, 60.0..90.0, 90.0..140.0]);
        assert_eq!(ranges(&columns, 10.0), [0.0..50.0, 50.0..80.0, 80.0..100.0]);
    }

    #[test]
    fn columns_lie_side_by_side_within_the_row() {
        let columns = [column(30.0, 0.2), column(50.0, 0.0), column(30.0, 1.7)];
        let found = ranges(&columns, 200.0);
        assert_eq!(found.len(), 3);
        assert!(found.windows(2).all(|w| w[1].start >= w[0].end));
        assert!(found.iter().all(|r| r.start >= 0.0 && r.end <= 200.001 && r.end > r.start));
    }

    #[test]
    fn columns_of_the_highest_rank_are_left_out_first() {
        let columns = [column(50.0, 0.0), column(40.0, 0.0).spare(1), column(30.0, 0.0).spare(2), column(20.0, 0.0)];
        let kept = |width| places(&columns, width).into_iter().map(|p| p.column).collect::<Vec<_>>();
        assert_eq!(kept(140.0), [0, 1, 2, 3]);
        assert_eq!(kept(139.0), [0, 1, 3]);
        assert_eq!(kept(109.0), [0, 3]);
        assert_eq!(kept(10.0), [0, 3]);
        let alike = [column(50.0, 0.0), column(40.0, 0.0).spare(1), column(40.0, 0.0).spare(1)];
        assert_eq!(fitting(&alike, 100.0), [0, 1]);
    }
}
