//! Dense sums of a set of nodes, four nodes side by side: every entry sums its points in their order.

use crate::body::batch::Answered;
use crate::body::node_blocks::NodeBlocks;
use crate::body::scatter::{ALL, FORCE, LOWER};
use mpm_grid::Vector;
use mpm_material::lanes::{LANES, Lanes, Number, each, four};

/// The dense sums of a set of nodes, and what its points need of its nodes.
#[derive(Debug)]
pub(crate) struct NodeSums<const D: usize> {
    /// Nodes of the set.
    n: usize,
    /// Packs of nodes.
    packs: usize,
    /// By pack and component.
    force: Vec<Lanes>,
    /// `g_vp` of a point, by pack and component.
    gradient: Vec<Lanes>,
    /// `t_vp` of a point, by pack; zero where there is no hoop.
    hoop: Vec<Lanes>,
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

impl<const D: usize> NodeSums<D> {
    /// For sets of up to `most_nodes` nodes.
    pub fn new(most_nodes: usize, takes_unsymmetric: bool) -> Self {
        let packs = most_nodes.div_ceil(LANES);
        let blocks = vec![Lanes::ZERO; most_nodes * packs * D * D];
        Self {
            n: 0,
            packs: 0,
            force: vec![Lanes::ZERO; packs * D],
            gradient: vec![Lanes::ZERO; packs * D],
            hoop: vec![Lanes::ZERO; packs],
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

    /// Adds a point.
    #[inline(always)]
    pub fn add<const TANGENT: u8, const HOOP: bool>(&mut self, point: SummedPoint<'_, D>) {
        // The commonest sets are compiled with their number of packs known.
        match self.packs {
            1 => self.add_packs::<TANGENT, HOOP>(1, point),
            2 => self.add_packs::<TANGENT, HOOP>(2, point),
            3 if D == 2 => self.add_packs::<TANGENT, HOOP>(3, point),
            packs => self.add_packs::<TANGENT, HOOP>(packs, point),
        }
    }

    #[inline(always)]
    fn add_packs<const TANGENT: u8, const HOOP: bool>(&mut self, packs: usize, point: SummedPoint<'_, D>) {
        let SummedPoint { answered, influences: (values, gradients), radius } = point;
        let force = &mut self.force[..packs * D];
        let g = &mut self.gradient[..packs * D];
        let t = &mut self.hoop[..packs];
        let of_radius = radius * answered.hoop();
        for pack in 0..packs {
            let dn = gradients_of(gradients, pack);
            for i in 0..D {
                let mut sum = Lanes::of(answered.inverse(0, i)) * dn[0];
                for (d, dn) in dn.iter().enumerate().skip(1) {
                    sum += Lanes::of(answered.inverse(d, i)) * *dn;
                }
                g[pack * D + i] = sum;
            }
            for i in 0..D {
                let mut of_node = Lanes::of(answered.stress(i, 0)) * g[pack * D];
                for j in 1..D {
                    of_node += Lanes::of(answered.stress(i, j)) * g[pack * D + j];
                }
                if HOOP && D == 3 && i == D - 1 {
                    of_node = of_node * Lanes::of(of_radius);
                }
                force[pack * D + i] += of_node;
            }
            if HOOP {
                t[pack] = values_of(values, pack) * Lanes::of(1.0 / of_radius);
                force[pack * D] += Lanes::of(answered.hoop_stress()) * t[pack];
            }
        }
        if TANGENT == FORCE {
            return;
        }
        // Most points of an unsymmetric law are elastic, and half of their blocks are enough.
        let (g, t) = (&*g, &*t);
        let blocks = self.n * packs * D * D;
        let of = (answered, of_radius);
        match TANGENT == ALL && !answered.is_symmetric {
            true => add_blocks::<D, ALL, HOOP>(packs, (g, t), of, &mut self.tangent[..blocks]),
            false if TANGENT == ALL => {
                add_blocks::<D, LOWER, HOOP>(packs, (g, t), of, &mut self.symmetric[..blocks]);
            }
            false => add_blocks::<D, LOWER, HOOP>(packs, (g, t), of, &mut self.tangent[..blocks]),
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
    each(|d| Lanes(four(|k| rest.get(k).map_or(0.0, |gradient| gradient[d]))))
}

/// Values of the nodes of a pack; zero behind the last node.
#[inline(always)]
fn values_of(values: &[f64], pack: usize) -> Lanes {
    let rest = &values[pack * LANES..];
    Lanes(four(|k| rest.get(k).copied().unwrap_or(0.0)))
}

/// Adds a point's tangent to the blocks: all of them, or those of a [`LOWER`] pass.
#[inline(always)]
fn add_blocks<const D: usize, const TANGENT: u8, const HOOP: bool>(
    packs: usize,
    (g, t): (&[Lanes], &[Lanes]),
    (answered, radius): (Answered<'_, D>, f64),
    sums: &mut [Lanes],
) {
    let volume = answered.volume();
    for (w, sums) in sums.chunks_exact_mut(packs * D * D).enumerate() {
        let (pack, lane) = (w / LANES, w % LANES);
        let node: [f64; D] = each(|l| g[pack * D + l].0[lane]);
        let weighted = each(|l| node[l] * volume);
        let first = if TANGENT == LOWER { pack } else { 0 };
        let column = Column { g, t, answered, first, node, weighted, hoop: t[pack].0[lane] };
        if HOOP && D == 3 {
            column.add_turning(radius, sums);
        } else {
            column.add::<HOOP>(sums);
        }
    }
}

/// The blocks of one column node.
struct Column<'a, const D: usize> {
    g: &'a [Lanes],
    t: &'a [Lanes],
    answered: Answered<'a, D>,
    /// First pack of row nodes.
    first: usize,
    /// g_w.
    node: [f64; D],
    /// V⁰ g_w.
    weighted: [f64; D],
    /// t_w.
    hoop: f64,
}

impl<const D: usize> Column<'_, D> {
    #[inline(always)]
    fn add<const HOOP: bool>(&self, sums: &mut [Lanes]) {
        // half[k](i, j) = V⁰ a_ikjl g_w,l
        let mut half = self.answered.half(&self.weighted, D);
        let mut row = [0.0; D];
        if HOOP {
            let hoop = self.hoop * self.answered.volume();
            for k in 0..2 {
                for i in 0..2 {
                    half[k * D * D + i] += self.answered.by_hoop(i, k).0 * hoop;
                    row[k] += self.answered.by_hoop(k, i).1 * self.weighted[i];
                }
            }
            row[0] += self.answered.hoop_modulus() * hoop;
        }
        for (pack, sums) in sums.chunks_exact_mut(D * D).enumerate().skip(self.first) {
            let g: [Lanes; D] = each(|k| self.g[pack * D + k]);
            for (entry, sum) in sums.iter_mut().enumerate() {
                let mut value = *sum;
                for k in 0..D {
                    value += Lanes::of(half[k * D * D + entry]) * g[k];
                }
                *sum = value;
            }
            if HOOP {
                for j in 0..D {
                    sums[j * D] += self.t[pack] * Lanes::of(row[j]);
                }
            }
        }
    }

    /// See `turning_tangent.rs`.
    #[inline(always)]
    fn add_turning(&self, radius: f64, sums: &mut [Lanes]) {
        let (hoop, answered) = (D - 1, self.answered);
        let stress = [answered.stress(hoop, 0), answered.stress(hoop, 1)];
        let weight = self.hoop * answered.volume();
        let at = |i: usize, k: usize, j: usize| (k * D + j) * D + i;
        let mut half = answered.half(&self.weighted, hoop);
        for k in 0..D {
            for i in 0..D {
                half[at(i, k, hoop)] *= radius;
                half[at(i, k, 0)] += answered.modulus([i, k, hoop, hoop]) * weight;
            }
        }
        let of_column = radius * (stress[0] * self.node[0] + stress[1] * self.node[1]);
        let arm = Lanes::of(radius * self.hoop);
        for (pack, sums) in sums.chunks_exact_mut(D * D).enumerate().skip(self.first) {
            let (g, t) = (&self.g[pack * D..], self.t[pack]);
            let of_rows = Lanes::of(stress[0]) * g[0] + Lanes::of(stress[1]) * g[1];
            for (entry, sum) in sums.iter_mut().enumerate() {
                let (i, j) = (entry % D, entry / D);
                let mut block = Lanes::of(half[at(i, 0, j)]) * g[0] + Lanes::of(half[at(i, 1, j)]) * g[1];
                if i == hoop {
                    block = block * Lanes::of(radius);
                }
                if i == 0 {
                    block += t * Lanes::of(half[at(hoop, hoop, j)]);
                }
                if (i, j) == (0, hoop) {
                    block += t * Lanes::of(of_column);
                }
                if (i, j) == (hoop, 0) {
                    block += arm * of_rows;
                }
                *sum += block;
            }
        }
    }
}
