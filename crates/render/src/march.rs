//! The way of a view ray through the drops: cell by cell, or in the equal steps of the papers.

use std::ops::ControlFlow;

use glam::Vec4;
use niji_dropfield::Bricks;
use niji_dropfield::Interpolation;
use niji_dropfield::Segment;
use niji_geometry::Ray;

use crate::cell_cubics::RADIUS_DENSITY_PIECES;
use crate::cell_cubics::cubics_through_samples;
use crate::cell_cubics::lanes;
use crate::cell_cubics::whole_cubic;
use crate::deposits::Deposits;
use crate::exponential::transmittance;
use crate::lane_cubic::LaneCubic;
use crate::levels::Integration;
use crate::merged_cells::MergedCells;
use crate::merged_cells::MergedPiece;
use crate::piece::EXTINCTION_PER_M2;
use crate::piece::Piece;
use crate::piece_rule::OPAQUE;
use crate::piece_rule::PieceRule;
use crate::size_axes::SizeAxes;
use crate::stretch::Crossing;
use crate::stretch::Stretch;
use crate::stretch::ThinCell;
use crate::stretch::join_all;

/// A distance at which the optical depth of the drops in front is wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    /// Distance from the eye (m).
    pub(crate) distance_m: f64,
    /// Optical depth of the drops in front at Q = 1.
    pub(crate) depth: f64,
}

impl Probe {
    /// A question not answered yet.
    pub(crate) fn at(distance_m: f64) -> Self {
        Self {
            distance_m,
            depth: 0.0,
        }
    }
}

/// The march through all modes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct March<'a> {
    /// The modes.
    pub(crate) bricks: &'a [Bricks],
    /// How pieces are evaluated.
    pub(crate) rule: PieceRule,
    /// Cells or steps.
    pub(crate) integration: Integration,
}

/// A ray on its way.
pub(crate) struct Walk<'a> {
    /// The ray.
    pub(crate) ray: &'a Ray,
    /// Distances between which there may be drops (m).
    pub(crate) range_m: (f64, f64),
    /// Size axes of the table; `None` where no light is gathered, only optical depth.
    pub(crate) axes: Option<&'a SizeAxes>,
    /// Distances at which light is handed over to be shaded, ascending.
    pub(crate) slab_ends_m: &'a [f64],
}

/// What a march leaves behind, besides the light it handed over.
struct Progress<'a, F: FnMut(&mut Deposits)> {
    walk: &'a Walk<'a>,
    rule: &'a PieceRule,
    depth: f64,
    /// exp(-Q tau) of the drops in front, as the gathered pieces left it.
    through: f64,
    n_slabs_closed: usize,
    probes: &'a mut [Probe],
    n_probes_passed: usize,
    deposits: &'a mut Deposits,
    /// Thin cells of each mode whose light waits to be gathered.
    stretches: &'a mut [Stretch],
    close_slab: F,
}

impl March<'_> {
    /// Optical depth of the drops at Q = 1 between two distances of a ray.
    pub(crate) fn depth(&self, ray: &Ray, range_m: (f64, f64)) -> f64 {
        let walk = Walk {
            ray,
            range_m,
            axes: None,
            slab_ends_m: &[],
        };
        let no_sizes = SizeAxes::new(&[1.0], &[0.0]);
        self.along(&walk, &mut [], &mut Deposits::new(&no_sizes), |_| ())
    }

    /// March along a ray; returns the optical depth of the drops at Q = 1 and fills the probes.
    /// `close_slab` gets the light of each slab, in order, to shade and clear.
    pub(crate) fn along(
        &self,
        walk: &Walk,
        probes: &mut [Probe],
        deposits: &mut Deposits,
        close_slab: impl FnMut(&mut Deposits),
    ) -> f64 {
        let (mut of_one, mut of_several);
        let stretches = match self.bricks {
            [_] => {
                of_one = [Stretch::default()];
                &mut of_one[..]
            }
            modes => {
                of_several = vec![Stretch::default(); modes.len()];
                &mut of_several[..]
            }
        };
        let mut progress = Progress {
            walk,
            rule: &self.rule,
            depth: 0.0,
            through: 1.0,
            n_slabs_closed: 0,
            probes,
            n_probes_passed: 0,
            deposits,
            stretches,
            close_slab,
        };
        match self.integration {
            Integration::FixedStep { step_m } => self.steps(step_m, &mut progress),
            Integration::CellExact | Integration::Adaptive { .. } => match self.bricks {
                [mode] => cells(mode, &mut progress),
                modes => merged_cells(modes, &mut progress),
            },
        }
        progress.finish()
    }

    /// The published sum: equal steps from the face on, each seen at its middle.
    fn steps<F: FnMut(&mut Deposits)>(&self, step_m: f64, progress: &mut Progress<F>) {
        let (enter_m, leave_m) = progress.walk.range_m;
        let n_steps = ((leave_m - enter_m) / step_m).ceil() as usize;
        for step in 0..n_steps {
            let start_m = enter_m + step as f64 * step_m;
            let end_m = (start_m + step_m).min(leave_m);
            let point = progress.walk.ray.at(0.5 * (start_m + end_m));
            let per_m2 = EXTINCTION_PER_M2 * (end_m - start_m);
            let m2: f64 = self
                .bricks
                .iter()
                .map(|mode| f64::from(mode.m2(point)))
                .sum();
            let step_depth = per_m2 * m2;
            progress.pass((start_m, end_m), |x| x * step_depth);
            if m2 > 0.0 {
                for mode in self.bricks {
                    // Embedded rule of twice the step: the steps of one parity.
                    let sign = if step % 2 == 0 { 1.0 } else { -1.0 };
                    let middle = Middle {
                        start_m,
                        end_m,
                        step_depth,
                        lanes: lanes(mode.sample(point)),
                    };
                    self.gather_step(&middle, sign, progress);
                }
            }
            if progress.leave(step_depth).is_break() {
                break;
            }
        }
    }

    fn gather_step<F: FnMut(&mut Deposits)>(
        &self,
        step: &Middle,
        sign: f64,
        progress: &mut Progress<F>,
    ) {
        let (Some(axes), true) = (progress.walk.axes, step.lanes.x > 0.0) else {
            return;
        };
        let in_front = progress.depth + 0.5 * step.step_depth;
        let through = (-self.rule.view_efficiency * in_front).exp();
        let sunlit = transmittance(self.rule.sun_efficiency as f32 * step.lanes.w);
        let column = EXTINCTION_PER_M2 * (step.end_m - step.start_m) * f64::from(step.lanes.x);
        let light = column * through * f64::from(sunlit);
        let place = axes.place(step.lanes.x, step.lanes.y, step.lanes.z);
        let middle_m = 0.5 * (step.start_m + step.end_m);
        progress
            .deposits
            .add(place, middle_m, f64::from(step.lanes.w), light);
        progress.deposits.error += sign * light;
    }
}

/// A step of the literal march in one mode.
struct Middle {
    start_m: f64,
    end_m: f64,
    step_depth: f64,
    lanes: Vec4,
}

impl<F: FnMut(&mut Deposits)> Progress<'_, F> {
    /// Enter a stretch: hand over the slab that ended before it, and answer the probes inside it.
    #[inline]
    fn pass(&mut self, (start_m, end_m): (f64, f64), depth_up_to: impl Fn(f64) -> f64) {
        let ends = self.walk.slab_ends_m;
        while self.n_slabs_closed < ends.len() && start_m >= ends[self.n_slabs_closed] {
            self.close();
        }
        while let Some(probe) = self.probes.get_mut(self.n_probes_passed)
            && probe.distance_m < end_m
        {
            let x = ((probe.distance_m - start_m) / (end_m - start_m)).max(0.0);
            probe.depth = self.depth + depth_up_to(x);
            self.n_probes_passed += 1;
        }
    }

    /// Leave a stretch of optical depth `depth`; break where nothing behind it is seen.
    #[inline]
    fn leave(&mut self, depth: f64) -> ControlFlow<()> {
        self.depth += depth;
        if self.rule.view_efficiency * self.depth > OPAQUE {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    /// Take a piece of a ray whose moments make a relative `error`.
    #[inline]
    fn piece(&mut self, piece: &Piece, error: f32) -> ControlFlow<()> {
        let end_m = piece.start_m + piece.length_m;
        self.pass((piece.start_m, end_m), |x| piece.depth_up_to(x));
        let depth = piece.depth();
        if let (Some(axes), true) = (self.walk.axes, depth > 0.0) {
            self.gather_stretches(axes);
            let before = self.deposits.light;
            self.rule
                .gather(axes, piece, &mut self.through, self.deposits);
            self.deposits.error += f64::from(error) * (self.deposits.light - before);
        }
        self.leave(depth)
    }

    /// Take the run of a ray through a cell of a single mode, or a part of it: with others in a stretch,
    /// or as a piece. Its lanes make a relative `error`.
    #[inline]
    fn cell(
        &mut self,
        start_m: f64,
        length_m: f64,
        lanes: &LaneCubic,
        error: f32,
    ) -> ControlFlow<()> {
        let modes = std::slice::from_ref(lanes);
        let Some(axes) = self.walk.axes else {
            return self.piece(&Piece::new(start_m, length_m, modes), error);
        };
        let thin = ThinCell::new(start_m, length_m, lanes, error);
        self.pass((start_m, start_m + length_m), |x| {
            Piece::new(start_m, length_m, modes).depth_up_to(x)
        });
        if thin.depth <= 0.0 {
            return ControlFlow::Continue(());
        }
        if !self.stretches[0].join(&thin, self.rule, axes) {
            self.gather_stretches(axes);
            if !self.stretches[0].join(&thin, self.rule, axes) {
                return self.piece(&Piece::new(start_m, length_m, modes), error);
            }
        }
        self.leave(thin.depth)
    }

    /// Take a piece in cells of several modes, with others in a stretch or alone.
    fn merged(&mut self, merged: &MergedPiece) -> ControlFlow<()> {
        let piece = &merged.piece;
        let Some(axes) = self.walk.axes else {
            return self.piece(piece, merged.error);
        };
        let end_m = piece.start_m + piece.length_m;
        self.pass((piece.start_m, end_m), |x| piece.depth_up_to(x));
        let depth = piece.depth();
        let rule = self.rule;
        let crossing = Crossing { rule, axes };
        if !join_all(self.stretches, merged.thin, depth, crossing) {
            self.gather_stretches(axes);
            if !join_all(self.stretches, merged.thin, depth, crossing) {
                return self.piece(piece, merged.error);
            }
        }
        self.leave(depth)
    }

    /// Gather the light that waits, before any that is behind it.
    #[inline]
    fn gather_stretches(&mut self, axes: &SizeAxes) {
        if self.stretches.iter().any(|stretch| !stretch.is_empty()) {
            self.rule
                .gather_stretches(axes, self.stretches, &mut self.through, self.deposits);
        }
    }

    fn close(&mut self) {
        if let Some(axes) = self.walk.axes {
            self.gather_stretches(axes);
        }
        self.n_slabs_closed += 1;
        if self.deposits.light > 0.0 {
            (self.close_slab)(self.deposits);
        }
        self.deposits.clear();
    }

    fn finish(mut self) -> f64 {
        for probe in &mut self.probes[self.n_probes_passed..] {
            probe.depth = self.depth;
        }
        self.close();
        self.depth
    }
}

/// One mode: its cells are the pieces.
fn cells<F: FnMut(&mut Deposits)>(mode: &Bricks, progress: &mut Progress<F>) {
    let walk = progress.walk;
    let (origin, direction) = (walk.ray.origin, walk.ray.direction);
    let allowed = progress.rule.relative_error();
    for segment in mode.coarse_segments(origin, direction, walk.range_m, allowed) {
        let flow = match mode.interpolation() {
            Interpolation::Moments if segment.is_coarse() => coarse_cell(segment, progress),
            Interpolation::Moments => whole_cell(&segment, progress),
            Interpolation::RadiusDensity => sampled_cell(&segment, progress),
        };
        if flow.is_break() {
            return;
        }
    }
}

/// A cell whose lanes are cubics.
#[allow(
    clippy::inline_always,
    reason = "most of a march is in cells of one voxel"
)]
#[inline(always)]
fn whole_cell<F: FnMut(&mut Deposits)>(
    segment: &Segment,
    progress: &mut Progress<F>,
) -> ControlFlow<()> {
    let length_m = segment.t_exit - segment.t_enter;
    let (lanes, error) = whole_cubic(segment);
    progress.cell(segment.t_enter, length_m, &lanes, error)
}

/// One of several voxels. Out of line and by value: for cells of one voxel nothing is copied then.
#[inline(never)]
fn coarse_cell<F: FnMut(&mut Deposits)>(
    segment: Segment,
    progress: &mut Progress<F>,
) -> ControlFlow<()> {
    whole_cell(&segment, progress)
}

/// A cell in which moments are no cubics, in its parts.
fn sampled_cell<F: FnMut(&mut Deposits)>(
    segment: &Segment,
    progress: &mut Progress<F>,
) -> ControlFlow<()> {
    let length_m = (segment.t_exit - segment.t_enter) / RADIUS_DENSITY_PIECES as f64;
    for (index, lanes) in cubics_through_samples(segment).iter().enumerate() {
        let start_m = segment.t_enter + index as f64 * length_m;
        progress.cell(start_m, length_m, lanes, 0.0)?;
    }
    ControlFlow::Continue(())
}

/// Several modes, whose lattices need have nothing in common: pieces lie between all their faces.
fn merged_cells<F: FnMut(&mut Deposits)>(modes: &[Bricks], progress: &mut Progress<F>) {
    let walk = progress.walk;
    let allowed = progress.rule.relative_error();
    let mut pieces = MergedCells::new(modes, walk.ray, walk.range_m, allowed);
    while let Some(piece) = pieces.next_piece() {
        if progress.merged(&piece).is_break() {
            return;
        }
    }
}
