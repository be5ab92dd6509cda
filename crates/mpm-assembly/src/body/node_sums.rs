//! Dense sums of a set of nodes, four nodes side by side: every entry sums its points in their order.

use crate::body::batch::Answered;
use crate::body::node_blocks::NodeBlocks;
use crate::body::scatter::{ALL, FORCE, LOWER};
use mpm_grid::Vector;
use mpm_material::lanes::{LANES, Lanes, Number, each, four};

/// Points that are added at once: few enough that their halves stay in the first cache.
pub(crate) const RUN: usize = 8;

/// The dense sums of a set of nodes, and what its points need of its nodes.
#[derive(Debug)]
pub(crate) struct NodeSums<const D: usize> {
    /// Nodes of the set.
    n: usize,
    /// Packs of nodes.
    packs: usize,
    /// By pack and component.
    force: Vec<Lanes>,
    /// `g_vp` by point of a run, pack and component.
    gradient: Vec<Lanes>,
    /// `t_vp` by point of a run and pack; zero where there is no hoop.
    hoop: Vec<Lanes>,
    /// Of the points of a run and one column node.
    columns: [Column; RUN],
    /// As [`NodeBlocks`].
    tangent: Vec<Lanes>,
    /// Of a pass for [`ALL`] blocks: the sum of the points whose tangent is symmetric, from the diagonal down.
    symmetric: Vec<Lanes>,
}

/// A point: what is known of it, its influences (values and gradients), its radius.
#[derive(Clone, Copy)]
pub(crate) struct SummedPoint<'a, const D: usize> {
    pub answered: Answered<'a, D>,
    pub influences: (&'a [f64], &'a [Vector<D>]),
    pub radius: f64,
}

impl<const D: usize> SummedPoint<'_, D> {
    /// No point.
    pub const NONE: Self = Self { answered: Answered::NONE, influences: (&[], &[]), radius: 1.0 };

    /// Radius at the end of the step, where there is a hoop.
    #[inline(always)]
    fn radius(&self) -> f64 {
        self.radius * self.answered.hoop()
    }
}

impl<const D: usize> NodeSums<D> {
    /// For sets of up to `most_nodes` nodes.
    pub fn new(most_nodes: usize, takes_unsymmetric: bool) -> Self {
        let packs = most_nodes.div_ceil(LANES);
        let blocks = vec![Lanes::ZERO; most_nodes * packs * D * D];
        Self {
            n: 0,
            packs: 0,
            force: vec![Lanes::ZERO; packs * D],
            gradient: vec![Lanes::ZERO; RUN * packs * D],
            hoop: vec![Lanes::ZERO; RUN * packs],
            columns: [Column::NONE; RUN],
            symmetric: if takes_unsymmetric { blocks.clone() } else { Vec::new() },
            tangent: blocks,
        }
    }

    /// Begins a set of n nodes.
    #[inline(always)]
    pub fn begin<const TANGENT: u8>(&mut self, n: usize) {
        (self.n, self.packs) = (n, n.div_ceil(LANES));
        self.force[..self.packs * D].fill(Lanes::ZERO);
        let column = self.packs * D * D;
        match TANGENT {
            FORCE => {}
            LOWER => clear_lower::<D>(&mut self.tangent[..n * column], column),
            _ => {
                self.tangent[..n * column].fill(Lanes::ZERO);
                clear_lower::<D>(&mut self.symmetric[..n * column], column);
            }
        }
    }

    /// Adds up to [`RUN`] points.
    #[inline(always)]
    pub fn add<const TANGENT: u8, const HOOP: bool, const VECTORS: bool>(
        &mut self,
        run: &[SummedPoint<'_, D>],
    ) {
        if !VECTORS {
            return self.add_packs::<TANGENT, HOOP>(self.packs, run);
        }
        // The commonest sets are compiled with their number of packs known.
        match self.packs {
            1 if D == 2 => self.add_packs::<TANGENT, HOOP>(1, run),
            2 => self.add_packs::<TANGENT, HOOP>(2, run),
            3 if D == 2 => self.add_packs::<TANGENT, HOOP>(3, run),
            packs => self.add_packs::<TANGENT, HOOP>(packs, run),
        }
    }

    #[inline(always)]
    fn add_packs<const TANGENT: u8, const HOOP: bool>(&mut self, packs: usize, run: &[SummedPoint<'_, D>]) {
        self.add_forces::<TANGENT, HOOP>(packs, run);
        if TANGENT == FORCE {
            return;
        }
        let (mut from, mut to) = (0, 0);
        while from < run.len() {
            let is_symmetric = run[from].answered.is_symmetric;
            while to < run.len() && (TANGENT == LOWER || run[to].answered.is_symmetric == is_symmetric) {
                to += 1;
            }
            let blocks = Blocks {
                packs,
                run: &run[from..to],
                g: &self.gradient[from * packs * D..to * packs * D],
                t: &self.hoop[from * packs..to * packs],
            };
            let (n, columns) = (self.n * packs * D * D, &mut self.columns);
            // Most points of an unsymmetric law are elastic, and half of their blocks are enough.
            match (TANGENT == ALL, is_symmetric) {
                (true, false) => blocks.add::<ALL, HOOP>(&mut self.tangent[..n], columns),
                (true, true) => blocks.add::<LOWER, HOOP>(&mut self.symmetric[..n], columns),
                (false, _) => blocks.add::<LOWER, HOOP>(&mut self.tangent[..n], columns),
            }
            from = to;
        }
    }

    /// Adds the forces of a run, and keeps what its tangents need of the nodes.
    #[inline(always)]
    fn add_forces<const TANGENT: u8, const HOOP: bool>(&mut self, packs: usize, run: &[SummedPoint<'_, D>]) {
        for pack in 0..packs {
            let sums = &mut self.force[pack * D..(pack + 1) * D];
            let mut force: [Lanes; D] = each(|i| sums[i]);
            for (k, point) in run.iter().enumerate() {
                let (values, gradients) = point.influences;
                let dn = gradients_of(gradients, pack);
                for (i, force) in force.iter_mut().enumerate() {
                    let mut of_node = product(|d| point.answered.force(i, d), &dn);
                    if HOOP && D == 3 && i == D - 1 {
                        of_node = of_node * Lanes::of(point.radius());
                    }
                    *force += of_node;
                }
                let at = k * packs + pack;
                if HOOP {
                    let t = values_of(values, pack) * Lanes::of(1.0 / point.radius());
                    force[0] += Lanes::of(point.answered.hoop_stress()) * t;
                    if TANGENT != FORCE {
                        self.hoop[at] = t;
                    }
                }
                if TANGENT != FORCE {
                    for (i, g) in self.gradient[at * D..(at + 1) * D].iter_mut().enumerate() {
                        *g = product(|d| point.answered.inverse(d, i), &dn);
                    }
                }
            }
            sums.copy_from_slice(&force);
        }
    }

    /// Ends the set: adds the sum of symmetric tangents to all blocks.
    #[inline(always)]
    pub fn end<const TANGENT: u8>(&mut self) {
        if TANGENT != ALL {
            return;
        }
        let at = |v: usize, w: usize| (w * self.packs + v / LANES) * D * D;
        for w in 0..self.n {
            for v in w..self.n {
                for entry in 0..D * D {
                    let value = self.symmetric[at(v, w) + entry].0[v % LANES];
                    self.tangent[at(v, w) + entry].0[v % LANES] += value;
                    if v > w {
                        let (i, j) = (entry % D, entry / D);
                        self.tangent[at(w, v) + i * D + j].0[w % LANES] += value;
                    }
                }
            }
        }
    }

    /// `fⁱⁿᵗ_v`.
    #[inline(always)]
    pub fn force(&self, v: usize) -> Vector<D> {
        let of = &self.force[v / LANES * D..][..D];
        Vector::from_fn(|i, _| of[i].0[v % LANES])
    }

    /// The tangent.
    #[inline(always)]
    pub fn blocks(&self) -> NodeBlocks<'_, D> {
        NodeBlocks { packs: self.packs, blocks: &self.tangent[..self.n * self.packs * D * D] }
    }
}

/// Clears the blocks from the diagonal down.
#[inline(always)]
fn clear_lower<const D: usize>(blocks: &mut [Lanes], column: usize) {
    for (w, blocks) in blocks.chunks_exact_mut(column).enumerate() {
        for entry in &mut blocks[w / LANES * D * D..] {
            *entry = Lanes::ZERO;
        }
    }
}

/// Gradients of the nodes of a pack, by component; zero behind the last node.
#[inline(always)]
fn gradients_of<const D: usize>(gradients: &[Vector<D>], pack: usize) -> [Lanes; D] {
    let rest = &gradients[pack * LANES..];
    if let Some([a, b, c, e]) = rest.first_chunk::<LANES>() {
        return each(|d| Lanes([a[d], b[d], c[d], e[d]]));
    }
    let none = Vector::zeros();
    let nodes = four(|k| rest.get(k).unwrap_or(&none));
    each(|d| Lanes(nodes.map(|gradient| gradient[d])))
}

/// `Σ_d of(d) ∂_d S_v` of the nodes of a pack.
#[inline(always)]
fn product<const D: usize>(of: impl Fn(usize) -> f64, gradient: &[Lanes; D]) -> Lanes {
    let mut sum = Lanes::of(of(0)) * gradient[0];
    for (d, gradient) in gradient.iter().enumerate().skip(1) {
        sum += Lanes::of(of(d)) * *gradient;
    }
    sum
}

/// Values of the nodes of a pack; zero behind the last node.
#[inline(always)]
fn values_of(values: &[f64], pack: usize) -> Lanes {
    let rest = &values[pack * LANES..];
    Lanes(four(|k| rest.get(k).copied().unwrap_or(0.0)))
}

/// Points of a run whose tangents go to the same blocks, with their `g_vp` and `t_vp`.
struct Blocks<'a, const D: usize> {
    packs: usize,
    run: &'a [SummedPoint<'a, D>],
    g: &'a [Lanes],
    t: &'a [Lanes],
}

/// What a point and a column node have in common for the blocks of all rows.
#[derive(Clone, Copy, Debug)]
struct Column {
    /// `V⁰ a_ikjl g_w,l` at (k D + j) D + i, with what the hoop adds to it.
    half: [f64; 28],
    /// Of the hoop, by column of the block; of a body that turns see [`Self::turn`].
    row: [f64; 3],
}

impl<const D: usize> Blocks<'_, D> {
    /// Adds the tangents to the blocks: all of them, or those of a [`LOWER`] pass.
    #[inline(always)]
    fn add<const TANGENT: u8, const HOOP: bool>(&self, sums: &mut [Lanes], columns: &mut [Column; RUN]) {
        let packs = self.packs;
        for (w, sums) in sums.chunks_exact_mut(packs * D * D).enumerate() {
            let (pack_of_w, lane) = (w / LANES, w % LANES);
            for (k, (point, column)) in self.run.iter().zip(&mut *columns).enumerate() {
                let node: [f64; D] = each(|l| self.g[(k * packs + pack_of_w) * D + l].0[lane]);
                let hoop = if HOOP { self.t[k * packs + pack_of_w].0[lane] } else { 0.0 };
                if HOOP && D == 3 {
                    column.turn(point, &node, hoop);
                } else {
                    column.set::<D, HOOP>(point.answered, &node, hoop);
                }
            }
            let first = if TANGENT == LOWER { pack_of_w } else { 0 };
            for (pack, sums) in sums.chunks_exact_mut(D * D).enumerate().skip(first) {
                let mut sum: [[Lanes; D]; D] = [[Lanes::ZERO; D]; D];
                sum.as_flattened_mut().copy_from_slice(sums);
                for (k, (point, column)) in self.run.iter().zip(&*columns).enumerate() {
                    let g: [Lanes; D] = each(|i| self.g[(k * packs + pack) * D + i]);
                    let t = if HOOP { self.t[k * packs + pack] } else { Lanes::ZERO };
                    if HOOP && D == 3 {
                        column.add_turning(point, (&g, t), &mut sum);
                    } else {
                        column.add::<D, HOOP>((&g, t), &mut sum);
                    }
                }
                sums.copy_from_slice(sum.as_flattened());
            }
        }
    }
}

/// Where `a_ikj` stands among the halves of a body that turns.
#[inline(always)]
const fn half_at(i: usize, k: usize, j: usize) -> usize {
    (k * 3 + j) * 3 + i
}

impl Column {
    /// Of no point.
    const NONE: Self = Self { half: [0.0; 28], row: [0.0; 3] };

    #[inline(always)]
    fn set<const D: usize, const HOOP: bool>(&mut self, answered: Answered<'_, D>, node: &[f64; D], hoop: f64) {
        let Self { half, row } = self;
        let volume = answered.volume();
        let weighted = node.map(|g| g * volume);
        answered.put_half(&weighted, D, half);
        if HOOP {
            let hoop = hoop * volume;
            *row = [0.0; 3];
            for k in 0..2 {
                for i in 0..2 {
                    half[k * D * D + i] += answered.by_hoop(i, k).0 * hoop;
                    row[k] += answered.by_hoop(k, i).1 * weighted[i];
                }
            }
            row[0] += answered.hoop_modulus() * hoop;
        }
    }

    /// Adds the blocks of four row nodes.
    #[inline(always)]
    fn add<const D: usize, const HOOP: bool>(&self, (g, t): (&[Lanes; D], Lanes), sum: &mut [[Lanes; D]; D]) {
        for (j, sum) in sum.iter_mut().enumerate() {
            for (i, sum) in sum.iter_mut().enumerate() {
                let mut value = *sum;
                for (k, g) in g.iter().enumerate() {
                    value += Lanes::of(self.half[(k * D + j) * D + i]) * *g;
                }
                *sum = value;
            }
            if HOOP {
                sum[0] += t * Lanes::of(self.row[j]);
            }
        }
    }

    /// Of a body that turns, see `turning_tangent.rs`; `row` is what belongs to the column of the angle, then the arm of the
    /// row of the angle.
    #[inline(always)]
    fn turn<const D: usize>(&mut self, point: &SummedPoint<'_, D>, node: &[f64; D], hoop: f64) {
        let half = &mut self.half;
        let (answered, radius) = (point.answered, point.radius());
        let stress = answered.shear_stress();
        let volume = answered.volume();
        let weight = hoop * volume;
        let weighted = node.map(|g| g * volume);
        let angle = D - 1;
        answered.put_half(&weighted, angle, half);
        for k in 0..D {
            for i in 0..D {
                half[half_at(i, k, angle)] *= radius;
                half[half_at(i, k, 0)] += answered.modulus([i, k, angle, angle]) * weight;
            }
        }
        let of_column = radius * (stress[0] * node[0] + stress[1] * node[1]);
        self.row = [of_column, radius * hoop, 0.0];
    }

    /// Adds the blocks of four row nodes of a body that turns.
    #[inline(always)]
    fn add_turning<const D: usize>(
        &self,
        point: &SummedPoint<'_, D>,
        (g, t): (&[Lanes; D], Lanes),
        sum: &mut [[Lanes; D]; D],
    ) {
        let (stress, radius, angle) = (point.answered.shear_stress(), Lanes::of(point.radius()), D - 1);
        let [of_column, arm, _] = self.row.map(Lanes::of);
        let of_rows = Lanes::of(stress[0]) * g[0] + Lanes::of(stress[1]) * g[1];
        for (j, sum) in sum.iter_mut().enumerate() {
            for (i, sum) in sum.iter_mut().enumerate() {
                let half = |k: usize| Lanes::of(self.half[half_at(i, k, j)]);
                let mut block = half(0) * g[0] + half(1) * g[1];
                if i == angle {
                    block = block * radius;
                }
                if i == 0 {
                    block += t * Lanes::of(self.half[half_at(angle, angle, j)]);
                }
                if (i, j) == (0, angle) {
                    block += t * of_column;
                }
                if (i, j) == (angle, 0) {
                    block += arm * of_rows;
                }
                *sum += block;
            }
        }
    }
}
