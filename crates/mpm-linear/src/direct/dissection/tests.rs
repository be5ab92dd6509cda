//! Orders are permutations, separators separate, and fill is what it should be.

use super::*;

/// Small reproducible pseudo-random numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

/// Lower triangle, by columns, of the couplings between nodes at most `reach` lines apart.
fn couplings(lattice: &[[u32; 3]], reach: [u32; 3], periodic: [Option<u32>; 3]) -> (Vec<usize>, Vec<usize>) {
    let close = |a: &[u32; 3], b: &[u32; 3]| {
        (0..3).all(|d| {
            let apart = a[d].abs_diff(b[d]);
            periodic[d].map_or(apart, |p| apart.min(p - apart)) <= reach[d]
        })
    };
    let (mut start, mut row) = (vec![0], Vec::new());
    for j in 0..lattice.len() {
        row.extend((j..lattice.len()).filter(|&i| close(&lattice[i], &lattice[j])));
        start.push(row.len());
    }
    (start, row)
}

fn full_lattice(n: [u32; 3]) -> Vec<[u32; 3]> {
    let mut lattice = Vec::new();
    for z in 0..n[2] {
        for y in 0..n[1] {
            lattice.extend((0..n[0]).map(|x| [x, y, z]));
        }
    }
    lattice
}

/// Entries of L, without relaxed supernodes, by plain symbolic elimination.
fn fill(graph: &BlockGraph, order: &[u32]) -> usize {
    let n = graph.len();
    let mut position = vec![0; n];
    for (k, &v) in order.iter().enumerate() {
        position[v as usize] = k;
    }
    let mut structure: Vec<Vec<usize>> = order
        .iter()
        .enumerate()
        .map(|(k, &v)| {
            graph.neighbours(v as usize).iter().map(|&w| position[w as usize]).filter(|&i| i > k).collect()
        })
        .collect();
    let mut entries = n;
    for k in 0..n {
        structure[k].sort_unstable();
        structure[k].dedup();
        entries += structure[k].len();
        if let Some((&parent, others)) = structure[k].split_first() {
            let others = others.to_vec();
            structure[parent].extend(others);
        }
    }
    entries
}

/// Active nodes, reach and rings.
type Case = (Vec<[u32; 3]>, [u32; 3], [Option<u32>; 3]);

/// Random cases.
fn cases() -> Vec<Case> {
    let mut random = Random(1);
    let mut cases = Vec::new();
    for case in 0..40 {
        let n = [random.below(12) as u32 + 1, random.below(9) as u32 + 1, random.below(5) as u32 + 1];
        let percent = random.below(100) + 1;
        let active = full_lattice(n).into_iter().filter(|_| random.below(100) < percent).collect();
        let reach = [0; 3].map(|_| random.below(3) as u32 + u32::from(case % 4 != 0));
        let ring = n.map(|p| (random.below(2) == 0).then_some(p));
        cases.push((active, reach, ring));
    }
    cases
}

/// The lower triangle of a pattern that couples `components` equations of each node.
fn in_blocks(start: &[usize], row: &[usize], components: usize) -> (Vec<usize>, Vec<usize>) {
    let (mut block_start, mut block_row) = (vec![0], Vec::new());
    for (v, entries) in start.windows(2).enumerate() {
        for component in 0..components {
            let first = |w: usize| if w == v { component } else { 0 };
            let rows = row[entries[0]..entries[1]].iter();
            block_row.extend(rows.flat_map(|&w| (first(w)..components).map(move |i| w * components + i)));
            block_start.push(block_row.len());
        }
    }
    (block_start, block_row)
}

#[test]
fn equations_of_no_node_come_last() {
    // Four nodes in a row with two equations each, and two equations that couple with everything.
    let lattice: Vec<[u32; 3]> = (0..4).map(|x| [x, 0, 0]).collect();
    let (mut start, mut row) = (vec![0], Vec::new());
    for j in 0..10 {
        row.extend((j..8).filter(|i| i / 2 - j / 2 <= 1).chain(8.max(j)..10));
        start.push(row.len());
    }
    let pattern = Pattern { blocks: 4, ..Pattern::symmetric(&start, &row, 2) };
    let order = elimination_order(pattern, &lattice, [None; 3], |_| None);
    assert_eq!(order[8..], [8, 9]);
    let nodes: Vec<usize> = order[..8].chunks(2).map(|pair| pair[0] / 2).collect();
    assert_eq!(
        nodes,
        elimination_order(
            Pattern::symmetric(&[0, 2, 4, 6, 7], &[0, 1, 1, 2, 2, 3, 3], 1),
            &lattice,
            [None; 3],
            |_| None
        )
    );
}

#[test]
fn equations_of_a_further_field_follow_those_of_their_node() {
    // Five nodes in a row with two equations each, a field on the last four of them, and an equation of no node.
    let lattice: Vec<[u32; 3]> = (0..5).map(|x| [x, 0, 0]).collect();
    let node = |equation: usize| if equation < 10 { equation / 2 } else { equation - 9 };
    let (mut start, mut row) = (vec![0], Vec::new());
    for j in 0..15 {
        row.extend((j..15).filter(|&i| i == 14 || node(i).abs_diff(node(j)) <= 1));
        start.push(row.len());
    }
    let (symmetry, block, blocks) = (crate::matrix::Symmetry::Symmetric, 2, 5);
    let pattern = Pattern { column_start: &start, row: &row, symmetry, block, blocks };
    let order =
        elimination_order(pattern, &lattice, [None; 3], |equation| (equation < 14).then(|| node(equation)));
    let mut expected = Vec::new();
    for node in
        elimination_order(pattern, &lattice, [None; 3], |_| None)[..10].chunks(2).map(|pair| pair[0] / 2)
    {
        expected.extend([2 * node, 2 * node + 1]);
        expected.extend((node > 0).then_some(9 + node));
    }
    expected.push(14);
    assert_eq!(order, expected);
}

#[test]
fn orders_of_random_active_sets_are_permutations() {
    for (lattice, reach, periodic) in cases() {
        for components in [1, 2, 3] {
            let (start, row) = couplings(&lattice, reach, periodic);
            let (start, row) = in_blocks(&start, &row, components);
            let pattern = Pattern::symmetric(&start, &row, components);
            let order = elimination_order(pattern, &lattice, periodic, |_| None);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..components * lattice.len()));
            for node in order.chunks(components) {
                assert!(
                    node.iter()
                        .enumerate()
                        .all(|(i, e)| e % components == i && e / components == node[0] / components)
                );
            }
            assert_eq!(order, elimination_order(pattern, &lattice, periodic, |_| None), "deterministic");
        }
    }
}

/// At every level: no coupling joins the two sides, and both have nodes.
fn assert_separates(graph: &BlockGraph, at: &mut Dissection, set: &mut [u32], ring: [Option<u32>; 3]) -> usize {
    let Some((left, right, ring)) = at.bisect(set, ring) else { return 0 };
    assert!(left > 0 && right > 0 && left + right <= set.len());
    let mut side = vec![0; graph.len()];
    set[..left].iter().for_each(|&v| side[v as usize] = 1);
    set[left..left + right].iter().for_each(|&v| side[v as usize] = 2);
    for &v in &set[..left] {
        assert!(graph.neighbours(v as usize).iter().all(|&w| side[w as usize] != 2));
    }
    let (below, rest) = set.split_at_mut(left);
    1 + assert_separates(graph, at, below, ring) + assert_separates(graph, at, &mut rest[..right], ring)
}

#[test]
fn separators_separate() {
    let mut cuts = 0;
    for (lattice, reach, periodic) in cases() {
        let (start, row) = couplings(&lattice, reach, periodic);
        let graph = BlockGraph::new(Pattern::symmetric(&start, &row, 1));
        let mut dissection = Dissection::new(&graph, &lattice, periodic);
        let mut set: Vec<u32> = (0..lattice.len() as u32).collect();
        cuts += assert_separates(&graph, &mut dissection, &mut set, periodic);
    }
    assert!(cuts > 200, "only {cuts} cuts tried");
}

#[test]
fn reach_is_measured_the_short_way_round() {
    let lattice = full_lattice([8, 6, 1]);
    for (reach, periodic) in [([1, 2, 0], [None; 3]), ([2, 1, 0], [Some(8), Some(6), None])] {
        let (start, row) = couplings(&lattice, reach, periodic);
        assert_eq!(BlockGraph::new(Pattern::symmetric(&start, &row, 1)).reach(&lattice, periodic), reach);
    }
}

#[test]
fn postorder_keeps_the_fill_and_puts_children_before_parents() {
    let lattice = full_lattice([9, 7, 3]);
    let (start, row) = couplings(&lattice, [1; 3], [None; 3]);
    let graph = BlockGraph::new(Pattern::symmetric(&start, &row, 1));
    let dissected = nested_dissection(&graph, &lattice, [None; 3]);
    let post = graph.postorder(&dissected);
    assert_eq!(fill(&graph, &dissected), fill(&graph, &post));
    assert_eq!(graph.postorder(&post), post, "a post-order is its own post-order");
}

#[test]
fn thick_separators_and_rings_pay() {
    // What the order would be without looking at the couplings: reach 1, no ring.
    let naive = |lattice: &[[u32; 3]]| {
        let (start, row) = couplings(lattice, [1, 1, 0], [None; 3]);
        nested_dissection(&BlockGraph::new(Pattern::symmetric(&start, &row, 1)), lattice, [None; 3])
    };
    for (n, reach, periodic) in
        [([40, 40, 1], [2, 2, 0], [None; 3]), ([120, 8, 1], [1, 1, 0], [Some(120), None, None])]
    {
        let lattice = full_lattice(n);
        let (start, row) = couplings(&lattice, reach, periodic);
        let graph = BlockGraph::new(Pattern::symmetric(&start, &row, 1));
        let ours = fill(&graph, &nested_dissection(&graph, &lattice, periodic));
        let naive = fill(&graph, &naive(&lattice));
        let natural = fill(&graph, &(0..lattice.len() as u32).collect::<Vec<_>>());
        assert!(ours < naive, "{n:?}: {ours} entries, {naive} without knowing");
        assert!(10 * ours < 8 * natural, "{n:?}: {ours} entries, {natural} in natural order");
    }
}

#[test]
fn separate_bodies_are_cut_apart_for_nothing() {
    let mut lattice = full_lattice([5, 5, 1]);
    lattice.extend(full_lattice([5, 5, 1]).iter().map(|&[x, y, z]| [x + 8, y, z]));
    let (start, row) = couplings(&lattice, [1, 1, 0], [None; 3]);
    let graph = BlockGraph::new(Pattern::symmetric(&start, &row, 1));
    let mut set: Vec<u32> = (0..50).collect();
    let (left, right, _) = Dissection::new(&graph, &lattice, [None; 3]).bisect(&mut set, [None; 3]).unwrap();
    assert_eq!((left, right), (25, 25));
}
