//! What of the sights along an azimuth something stands in, by their slopes (tangents of elevations).

use std::ops::Range;

/// Slopes that are covered.
#[derive(Clone, Debug, PartialEq)]
pub struct CoveredSlopes {
    /// From and to, rising; none touches another.
    spans: Vec<[f64; 2]>,
}

impl CoveredSlopes {
    /// All but a range.
    ///
    /// ```
    /// use niji_geometry::CoveredSlopes;
    /// let mut covered = CoveredSlopes::all_but(0.0..f64::INFINITY);
    /// covered.add([0.5, 1.0]);
    /// covered.add([0.9, 2.0]);
    /// assert_eq!(covered.gaps().collect::<Vec<_>>(), [0.0..0.5, 2.0..f64::INFINITY]);
    /// ```
    #[must_use]
    pub fn all_but(range: Range<f64>) -> Self {
        let mut covered = Self {
            spans: vec![[f64::NEG_INFINITY, range.start]],
        };
        covered.add([range.end, f64::INFINITY]);
        covered
    }

    /// Cover slopes from one to another, too.
    pub fn add(&mut self, [low, high]: [f64; 2]) {
        let first = self.spans.partition_point(|span| span[1] < low);
        let end = self.spans.partition_point(|span| span[0] <= high);
        if first >= end {
            self.spans.insert(first, [low, high]);
            return;
        }
        let last = self.spans[end - 1][1];
        let span = &mut self.spans[first];
        *span = [span[0].min(low), last.max(high)];
        self.spans.drain(first + 1..end);
    }

    /// The slopes that are free.
    pub fn gaps(&self) -> impl Iterator<Item = Range<f64>> {
        self.spans.windows(2).map(|pair| pair[0][1]..pair[1][0])
    }

    /// Whether all slopes from one to another are covered.
    pub(crate) fn hold(&self, [low, high]: [f64; 2]) -> bool {
        let index = self.spans.partition_point(|span| span[1] < low);
        let span = self.spans.get(index);
        span.is_some_and(|span| span[0] <= low && high <= span[1])
    }

    /// Whether none is free.
    pub(crate) fn are_all(&self) -> bool {
        self.spans.len() == 1
    }
}
