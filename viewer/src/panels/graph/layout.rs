//! Layout of clips, segments and states: along time, clips packed into rows.

use std::ops::Range;
use throng_core::{Bundle, graph::MotionSegment};

/// Rows aimed at; a clip that is longer than its share makes them longer instead.
const ROWS: std::ops::RangeInclusive<f32> = 3.0..=14.0;
/// Duration of motion that fills a row (s).
const ROW_S: f32 = 45.0;
/// Space between the clips of a row, as a share of its length.
const GAP: f32 = 0.012;

/// A clip that takes part.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipLane {
    /// Number of the clip.
    pub clip: usize,
    /// Row it lies in.
    pub row: usize,
    /// Place of the first used frame (s).
    pub start: f32,
    /// Place of the last used frame (s).
    pub end: f32,
    /// Frame row that lies at `start`.
    pub first_frame: u32,
    /// Segments that overlap in time lie in different tracks (>= 1).
    pub num_tracks: u32,
    /// Segments of the clip, as a range of [`GraphLayout::segments`].
    pub segments: Range<usize>,
}

/// A segment's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentBar {
    /// Number of the segment.
    pub segment: u32,
    /// Lane it lies in.
    pub lane: u32,
    /// Track within the lane.
    pub track: u32,
    /// Start along the row (s).
    pub start: f32,
    /// End along the row (s).
    pub end: f32,
}

/// The drawing without its scale.
#[derive(Clone, Debug, Default)]
pub struct GraphLayout {
    /// Clips that take part, by row and then by place.
    pub lanes: Vec<ClipLane>,
    /// Lanes of each row (number of rows).
    pub rows: Vec<Range<usize>>,
    /// Segments, by lane and then by start.
    pub segments: Vec<SegmentBar>,
    /// Place of each segment in `segments` (number of segments).
    pub bar_of: Vec<u32>,
    /// Bar with the state at its end, for each state with one (number of states).
    pub state_bars: Vec<Option<u32>>,
    /// Length of the longest row (s).
    pub length_s: f32,
    rate_hz: f32,
}

impl GraphLayout {
    /// Lays out the graph of a bundle.
    pub fn new(tables: &Bundle) -> Self {
        let graph = tables.graph();
        let rate_hz = tables.meta().rate_hz as f32;
        let mut order: Vec<u32> = (0..graph.segments.len() as u32).collect();
        order.sort_by_key(|&s| (graph.segments[s as usize].clip, graph.segments[s as usize].start));
        let mut layout = Self { rate_hz, ..Self::default() };
        for same in order.chunk_by(|&a, &b| graph.segments[a as usize].clip == graph.segments[b as usize].clip) {
            layout.add_lane(&graph.segments, same);
        }
        layout.pack();
        layout.bar_of = vec![0; graph.segments.len()];
        layout.state_bars = vec![None; graph.states.len()];
        for (i, bar) in layout.segments.iter().enumerate() {
            layout.bar_of[bar.segment as usize] = i as u32;
            layout.state_bars[graph.segments[bar.segment as usize].end as usize] = Some(i as u32);
        }
        layout
    }

    /// Adds a clip at time 0; `order` are its segments by their start.
    fn add_lane(&mut self, segments: &[MotionSegment], order: &[u32]) {
        let lane = self.lanes.len() as u32;
        let of = |s: &u32| &segments[*s as usize];
        let Some(first_frame) = order.iter().map(|s| of(s).start).min() else { return };
        let mut tracks: Vec<u32> = Vec::new();
        let from = self.segments.len();
        let mut last = first_frame;
        for &segment in order {
            let s = of(&segment);
            let end = s.start + s.num_frames;
            let track = tracks.iter().position(|&free| free <= s.start).unwrap_or(tracks.len());
            tracks.resize(tracks.len().max(track + 1), 0);
            tracks[track] = end;
            last = last.max(end);
            let at = |frame: u32| (frame - first_frame) as f32 / self.rate_hz;
            self.segments.push(SegmentBar { segment, lane, track: track as u32, start: at(s.start), end: at(end) });
        }
        self.lanes.push(ClipLane {
            clip: of(&order[0]).clip as usize,
            row: 0,
            start: 0.0,
            end: (last - first_frame) as f32 / self.rate_hz,
            first_frame,
            num_tracks: tracks.len() as u32,
            segments: from..self.segments.len(),
        });
    }

    /// Fills row after row with clips, in their order.
    fn pack(&mut self) {
        let total: f32 = self.lanes.iter().map(|l| l.end).sum();
        let longest = self.lanes.iter().map(|l| l.end).fold(0.0, f32::max);
        let rows = (total / ROW_S).ceil().clamp(*ROWS.start(), *ROWS.end());
        let room = longest.max(total / rows * 1.04).max(1.0);
        let gap = room * GAP;
        let mut x = 0.0;
        for i in 0..self.lanes.len() {
            let length = self.lanes[i].end;
            match self.rows.last_mut() {
                Some(row) if x + length <= room => row.end = i + 1,
                _ => {
                    self.rows.push(i..i + 1);
                    x = 0.0;
                }
            }
            let lane = &mut self.lanes[i];
            (lane.row, lane.start, lane.end) = (self.rows.len() - 1, x, x + length);
            for bar in &mut self.segments[lane.segments.clone()] {
                bar.start += x;
                bar.end += x;
            }
            self.length_s = self.length_s.max(x + length);
            x += length + gap;
        }
    }

    /// The bar that a segment is drawn as (segment < number of segments).
    pub fn bar(&self, segment: u32) -> &SegmentBar {
        &self.segments[self.bar_of[segment as usize] as usize]
    }

    /// Place of a moment of a segment along its row (frames from its start; s).
    pub fn moment(&self, bar: &SegmentBar, frames: f32) -> f32 {
        (bar.start + frames / self.rate_hz).min(bar.end)
    }

    /// Bars of a lane that overlap a range of places; may include neighbours.
    pub fn bars_within(&self, lane: &ClipLane, [low, high]: [f32; 2]) -> &[SegmentBar] {
        let bars = &self.segments[lane.segments.clone()];
        let longest = bars.iter().map(|b| b.end - b.start).fold(0.0, f32::max);
        let from = bars.partition_point(|b| b.start < low - longest);
        let to = bars.partition_point(|b| b.start <= high);
        &bars[from..to.max(from)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::golden;
    use super::*;

    #[test]
    fn lanes_of_a_row_do_not_overlap_and_all_segments_lie_in_theirs() {
        let b = golden();
        let layout = GraphLayout::new(b.tables());
        assert_eq!(layout.segments.len(), b.tables().graph().segments.len());
        for (r, row) in layout.rows.iter().enumerate() {
            let lanes = &layout.lanes[row.clone()];
            assert!(lanes.windows(2).all(|w| w[0].end < w[1].start));
            assert!(lanes.iter().all(|l| l.row == r && l.end <= layout.length_s));
        }
        assert_eq!(layout.rows.iter().map(|r| r.len()).sum::<usize>(), layout.lanes.len());
        for bar in &layout.segments {
            let lane = &layout.lanes[bar.lane as usize];
            assert!(bar.start >= lane.start - 1e-4 && bar.end <= lane.end + 1e-4 && bar.track < lane.num_tracks);
        }
    }

    #[test]
    fn segments_that_overlap_in_time_lie_in_different_tracks() {
        let segment =
            |start, num_frames| MotionSegment { start, num_frames, end: 0, clip: 0, displacement: [0.0; 3], idle: 0 };
        let segments = [segment(10, 20), segment(12, 18), segment(15, 30), segment(30, 5), segment(31, 4)];
        let mut layout = GraphLayout { rate_hz: 30.0, ..GraphLayout::default() };
        layout.add_lane(&segments, &[0, 1, 2, 3, 4]);
        assert_eq!(layout.lanes[0].num_tracks, 3);
        for (i, a) in layout.segments.iter().enumerate() {
            for b in &layout.segments[i + 1..] {
                assert!(a.track != b.track || a.end <= b.start || b.end <= a.start, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn visible_bars_of_a_lane_are_found() {
        let b = golden();
        let layout = GraphLayout::new(b.tables());
        for lane in &layout.lanes {
            for part in 0..8 {
                let low = lane.start + (lane.end - lane.start) * part as f32 / 8.0;
                let range = [low, low + 0.7];
                let found = layout.bars_within(lane, range);
                let seen = |bar: &&SegmentBar| bar.end >= range[0] && bar.start <= range[1];
                let all: Vec<&SegmentBar> = layout.segments[lane.segments.clone()].iter().filter(seen).collect();
                assert!(all.iter().all(|bar| found.contains(bar)));
            }
        }
    }
}
