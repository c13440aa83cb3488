use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

use super::faithful::Walker;
use super::outliers::outliers;
use super::proximity::Proximity;
use super::result::{Curve, Outcome, Reconstruction, Waypoint, total};
use super::route::{Net, Router};
use super::split::split;
use super::surface::Surface;
use super::tour::{Costs, tour};
use crate::mesh::vector::distance;
use crate::mesh::{Components, Search, TriMesh};
use catamaran::base::{Error, Progress, Result, at_least, options, reserved};

/// Least number of samples of a curve.
const LEAST: usize = 3;
/// Seed of the random changes of tours.
const SEED: u64 = 6;

/// The method by which a curve is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Algorithm 6.1 of the thesis, from sample to sample.
    Faithful,
    /// First the order of all samples, then paths that avoid each other.
    Robust,
    /// The samples are in the order of one curve already; paths avoid each other, as in the robust
    /// mode.
    Ordered,
}

/// The number of curves to which the samples belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// One curve.
    One,
    /// As many curves as the gaps between the samples tell, for closed curves of the robust mode;
    /// otherwise one.
    Automatic,
}

options! {
    /// Options of [`CurveSolver::reconstruct`].
    #[derive(Debug, Clone)]
    pub struct CurveOptions<'a> {
        /// The method.
        mode: Mode = Mode::Robust;
        /// Whether the curve is open, from one end to the other.
        open: bool = false;
        /// The number of curves.
        count: Count = Count::Automatic;
        /// In the robust mode, whether vertices may be inserted in the middle of edges where there
        /// is no other path.
        steiner: bool = true;
        /// Whether outliers are dropped: one or two successive samples to which the curve makes a
        /// detour of more than three times the median distance between successive samples. At the
        /// ends of an open curve, twice that distance counts. At least half of the samples stay.
        /// Not for the faithful mode.
        drop_outliers: bool = false;
        /// In the faithful mode, l, the number of nearest samples among which the next one is
        /// chosen.
        candidates: usize = 5, range "at least 1";
        /// In the faithful mode, the index of the sample at which the curve starts.
        start: usize = 0, range "below the number of samples";
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// Finds curves on a mesh. The solver is created in O(V + F), and serves many reconstructions,
/// which visit only the surroundings of the samples.
///
/// ```
/// use catamaran_geometry::{curve::{CurveOptions, CurveSolver, Outcome}, mesh::families};
///
/// let mesh = families::grid(8, 8)?;
/// let corners = [10, 70, 16, 64]; // of a square of 6 x 6 cells, not in order
/// let found = CurveSolver::new(&mesh)?.reconstruct(&corners, &CurveOptions::new())?;
/// assert_eq!(found.outcome, Outcome::Closed);
/// assert_eq!(found.curves[0].order.len(), 4);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct CurveSolver<'m> {
    surface: Surface<'m>,
    search: Search,
    marks: Vec<u8>,
    users: Vec<u16>,
    history: Vec<f32>,
}

impl<'m> CurveSolver<'m> {
    /// Creates a solver for any mesh: several components, boundary and edges of many faces are
    /// allowed.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn new(mesh: &'m TriMesh) -> Result<Self> {
        Self::of(Cow::Borrowed(mesh))
    }

    /// Creates a solver that owns its mesh.
    ///
    /// ```
    /// use catamaran_geometry::{curve::CurveSolver, mesh::families};
    ///
    /// let solver: CurveSolver<'static> = CurveSolver::owning(families::grid(8, 8)?)?;
    /// assert_eq!(solver.mesh().faces().len(), 128);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn owning(mesh: TriMesh) -> Result<CurveSolver<'static>> {
        CurveSolver::of(Cow::Owned(mesh))
    }

    /// Returns the mesh on which curves are found.
    pub fn mesh(&self) -> &TriMesh {
        self.surface.mesh()
    }

    fn of(mesh: Cow<'m, TriMesh>) -> Result<Self> {
        let n = mesh.vertices().len();
        Ok(Self {
            surface: Surface::new(mesh),
            search: Search::new(n)?,
            marks: filled(n)?,
            users: filled(n)?,
            history: filled(n)?,
        })
    }

    /// Finds a curve along edges through these vertices, in any order.
    ///
    /// In the faithful mode, the curve starts at sample `start`, in the ordered mode at the first
    /// sample. In the robust mode, each curve starts at its sample of lowest index, and continues
    /// with the lower one of its two neighbours. The same samples give the same result, bit for
    /// bit. Where there may be several curves, samples on components with fewer than three samples
    /// are [left out](Reconstruction::left_out), and the other samples get their curves. Where
    /// [outliers](Reconstruction::outliers) are dropped, the other samples get the same curves as a
    /// reconstruction of these samples alone.
    ///
    /// # Errors
    /// [`Error::Argument`] for fewer than three samples, a vertex that does not exist or occurs
    /// twice, no candidates, a start that is not the index of a sample, or outliers to drop in the
    /// faithful mode; [`Error::Mesh`] for a vertex without a face; [`Error::Cancelled`].
    pub fn reconstruct(
        &mut self,
        samples: &[u32],
        options: &CurveOptions<'_>,
    ) -> Result<Reconstruction> {
        self.check(samples, options)?;
        let found = options.progress.watch(|| match options.drop_outliers {
            true => self.without_outliers(samples, options),
            false => self.through_all(samples, options),
        });
        self.surface.forget_refinement();
        found
    }

    fn check(&self, samples: &[u32], options: &CurveOptions<'_>) -> Result<()> {
        let refused = |what, why| Err(Error::Argument { what, why });
        let n = self.surface.mesh().vertices().len();
        let mut first = HashMap::new();
        for (i, &v) in samples.iter().enumerate() {
            if v as usize >= n {
                let why = format!("sample {i} is vertex {v}, out of range: {n} vertices");
                return refused("samples", why);
            }
            if self.surface.component(v) == Components::NONE {
                let what = format!("sample {i} is in no face");
                return Err(Error::Mesh { what, element: format!("vertex {v}") });
            }
            if let Some(before) = first.insert(v, i) {
                return refused("samples", format!("sample {i} is vertex {v}, as sample {before}"));
            }
        }
        if samples.len() < LEAST {
            return refused("samples", format!("must be at least {LEAST}, are {}", samples.len()));
        }
        if options.mode == Mode::Faithful {
            if options.drop_outliers {
                return refused("drop_outliers", "the faithful mode takes every sample".into());
            }
            at_least("candidates", options.candidates, 1)?;
            if options.start >= samples.len() {
                let why = format!("must be below {}, is {}", samples.len(), options.start);
                return refused("start", why);
            }
        }
        Ok(())
    }

    /// Finds curves through all samples.
    fn through_all(
        &mut self,
        samples: &[u32],
        options: &CurveOptions<'_>,
    ) -> Result<Reconstruction> {
        match options.mode {
            Mode::Faithful => self.faithful(samples, options),
            Mode::Robust => self.robust(samples, options),
            Mode::Ordered => self.ordered(samples, options),
        }
    }

    /// Finds curves through the samples that are no outliers.
    fn without_outliers(
        &mut self,
        samples: &[u32],
        options: &CurveOptions<'_>,
    ) -> Result<Reconstruction> {
        let mut kept = Vec::new();
        for group in self.groups(samples) {
            kept.extend(self.kept(samples, group, options)?);
        }
        kept.sort_unstable();
        let own: Vec<u32> = kept.iter().map(|&i| samples[i as usize]).collect();
        let mut found = self.through_all(&own, options)?;
        found.renumber(&kept);
        let all = 0..samples.len() as u32;
        found.outliers = all.filter(|i| kept.binary_search(i).is_err()).collect();
        Ok(found)
    }

    /// Returns a group of samples without its outliers: at least half of it, and three samples.
    fn kept(
        &mut self,
        samples: &[u32],
        mut group: Vec<u32>,
        options: &CurveOptions<'_>,
    ) -> Result<Vec<u32>> {
        let fewest = LEAST.max(group.len().div_ceil(2));
        while group.len() > fewest {
            options.progress.report(0.0)?;
            let vertices: Vec<u32> = group.iter().map(|&i| samples[i as usize]).collect();
            let proximity = Proximity::new(&self.surface, &mut self.search, &vertices)?;
            let all: Vec<u32> = (0..group.len() as u32).collect();
            let order = match options.mode {
                Mode::Ordered => all,
                _ => tour(&Costs::new(&proximity, &all, options.open), SEED)?,
            };
            let mut found = outliers(&proximity, &order, options.open);
            found.truncate(group.len() - fewest);
            if found.is_empty() {
                break;
            }
            let kept = (0..).zip(&group).filter(|(place, _)| !found.contains(place));
            group = kept.map(|(_, &i)| i).collect();
        }
        Ok(group)
    }

    /// Returns the samples of each component of the mesh, by index.
    fn groups(&self, samples: &[u32]) -> Vec<Vec<u32>> {
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (i, &v) in (0..).zip(samples) {
            groups.entry(self.surface.component(v)).or_default().push(i);
        }
        groups.into_values().collect()
    }

    fn faithful(&mut self, samples: &[u32], options: &CurveOptions<'_>) -> Result<Reconstruction> {
        let components = self.groups(samples).len();
        let mut walker = Walker {
            surface: &self.surface,
            search: &mut self.search,
            marks: &mut self.marks,
            samples,
        };
        let (start, progress) = (options.start as u32, options.progress);
        let walk = walker.walk(start, options.candidates, options.open, progress)?;
        let outcome = match walk.outcome {
            Outcome::Blocked { .. } if components > 1 => Outcome::Disconnected { components },
            outcome => outcome,
        };
        let curve = self.curve(walk.order, walk.path, outcome == Outcome::Closed);
        Ok(Reconstruction { curves: vec![curve], ..Reconstruction::without_curves(outcome) })
    }

    fn robust(&mut self, samples: &[u32], options: &CurveOptions<'_>) -> Result<Reconstruction> {
        let mut groups = self.groups(samples);
        let several = options.count == Count::Automatic && !options.open;
        let components = groups.len();
        let mut left_out = Vec::new();
        if several || options.drop_outliers {
            left_out = too_few(&mut groups);
        }
        if groups.is_empty() || groups.len() > 1 && !several {
            let none = Reconstruction::without_curves(Outcome::Disconnected { components });
            return Ok(Reconstruction { left_out, ..none });
        }
        let mut orders = Vec::new();
        for group in &groups {
            options.progress.report(0.0)?;
            orders.extend(self.orders(samples, group, options.open, several)?);
        }
        orders.sort_unstable_by_key(|order| order[0]);
        Ok(Reconstruction { left_out, ..self.routed(samples, &orders, options)? })
    }

    /// Finds a path through the samples in their given order.
    fn ordered(&mut self, samples: &[u32], options: &CurveOptions<'_>) -> Result<Reconstruction> {
        let mut groups = self.groups(samples);
        let components = groups.len();
        let left_out = if options.drop_outliers { too_few(&mut groups) } else { Vec::new() };
        if groups.len() != 1 {
            let none = Reconstruction::without_curves(Outcome::Disconnected { components });
            return Ok(Reconstruction { left_out, ..none });
        }
        Ok(Reconstruction { left_out, ..self.routed(samples, &groups, options)? })
    }

    /// Returns the order of each curve through a group of samples.
    fn orders(
        &mut self,
        samples: &[u32],
        group: &[u32],
        open: bool,
        several: bool,
    ) -> Result<Vec<Vec<u32>>> {
        let vertices: Vec<u32> = group.iter().map(|&i| samples[i as usize]).collect();
        let proximity = Proximity::new(&self.surface, &mut self.search, &vertices)?;
        let all: Vec<u32> = (0..group.len() as u32).collect();
        let best = |members: &[u32]| tour(&Costs::new(&proximity, members, open), SEED);
        let whole = best(&all)?;
        let parts = if several { split(&proximity, whole) } else { vec![whole] };
        let numbered = |tour: Vec<u32>| {
            let order: Vec<u32> = tour.into_iter().map(|i| group[i as usize]).collect();
            normalized(order, open)
        };
        Ok(parts.into_iter().map(numbered).collect())
    }

    /// Finds paths through the samples in these orders.
    fn routed(
        &mut self,
        samples: &[u32],
        orders: &[Vec<u32>],
        options: &CurveOptions<'_>,
    ) -> Result<Reconstruction> {
        let nets: Vec<Vec<Net>> =
            orders.iter().map(|order| nets(samples, order, options.open)).collect();
        let mut router = Router {
            surface: &mut self.surface,
            search: &mut self.search,
            marks: &mut self.marks,
            users: &mut self.users,
            history: &mut self.history,
        };
        let progress = options.progress.part(0.3..1.0);
        let paths = router.route(&nets.concat(), samples, options.steiner, progress)?;
        let mut paths = paths.into_iter();
        let mut outcome = if options.open { Outcome::Open } else { Outcome::Closed };
        let mut curves = Vec::new();
        for (order, nets) in orders.iter().zip(&nets) {
            let own: Vec<_> = paths.by_ref().take(nets.len()).collect();
            let (curve, ended) = self.joined(order.clone(), own, options.open);
            if outcome.is_complete() {
                outcome = ended;
            }
            curves.push(curve);
        }
        let steiner = self.surface.bisected().to_vec();
        Ok(Reconstruction { curves, steiner, ..Reconstruction::without_curves(outcome) })
    }

    /// Joins the paths of a curve, from the end of the first missing path to the next one.
    fn joined(
        &self,
        mut order: Vec<u32>,
        mut paths: Vec<Option<Vec<u32>>>,
        open: bool,
    ) -> (Curve, Outcome) {
        let missing = paths.iter().filter(|path| path.is_none()).count();
        let outcome = match missing {
            0 if open => Outcome::Open,
            0 => Outcome::Closed,
            1 if !open => Outcome::CloseBlocked,
            _ => {
                let gap = paths.iter().position(Option::is_none).unwrap_or_default();
                Outcome::Blocked { at: order[gap], remaining: order.len() - gap - 1 }
            }
        };
        if outcome == Outcome::CloseBlocked {
            let gap = paths.iter().position(Option::is_none).unwrap_or_default();
            let shift = (gap + 1) % order.len();
            order.rotate_left(shift);
            paths.rotate_left(shift);
        }
        let mut path = Vec::new();
        for part in &paths {
            match part {
                Some(part) => path.extend(&part[..part.len() - 1]),
                None => break,
            }
        }
        if outcome != Outcome::Closed {
            let last = paths.iter().map_while(|part| part.as_ref()?.last()).last();
            path.extend(last);
        }
        (self.curve(order, path, outcome == Outcome::Closed), outcome)
    }

    fn curve(&self, order: Vec<u32>, path: Vec<u32>, closed: bool) -> Curve {
        let points: Vec<[f64; 3]> = path.iter().map(|&v| self.surface.position(v)).collect();
        let mut length = total(points.windows(2).map(|pair| distance(pair[0], pair[1])));
        if let (true, &[first, .., last]) = (closed, &points[..]) {
            length += distance(last, first);
        }
        let waypoints = path.iter().map(|&v| Waypoint::Vertex(v)).collect();
        Curve { order, path, points, waypoints, closed, length }
    }
}

/// Returns n default values.
fn filled<T: Clone + Default>(n: usize) -> Result<Vec<T>> {
    let mut all = reserved(n)?;
    all.resize(n, T::default());
    Ok(all)
}

/// Removes the groups that are too few samples for a curve, and returns these samples, ascending.
fn too_few(groups: &mut Vec<Vec<u32>>) -> Vec<u32> {
    let mut few: Vec<u32> = groups.extract_if(.., |group| group.len() < LEAST).flatten().collect();
    few.sort_unstable();
    few
}

/// Returns the pairs of vertices that follow each other.
fn nets(samples: &[u32], order: &[u32], open: bool) -> Vec<Net> {
    let next = order.iter().cycle().skip(1);
    let pairs = order.iter().zip(next).map(|(&i, &j)| (samples[i as usize], samples[j as usize]));
    pairs.take(order.len() - usize::from(open)).collect()
}

/// Returns the canonical form of an order: it begins with the lowest index and continues with its
/// lower neighbour; an open order begins with its lower end.
fn normalized(mut order: Vec<u32>, open: bool) -> Vec<u32> {
    if open {
        if order.first() > order.last() {
            order.reverse();
        }
        return order;
    }
    let lowest = (0..order.len()).min_by_key(|&i| order[i]).unwrap_or_default();
    order.rotate_left(lowest);
    if order.get(1) > order.last() {
        order[1..].reverse();
    }
    order
}
