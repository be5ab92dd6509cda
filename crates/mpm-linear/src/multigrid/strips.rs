//! The order of the nodes of one lattice: strips of lines, even ones before odd ones.

/// Strips along the longest direction, at most.
const MOST: u32 = 32;

/// Nodes in the order of their strips.
#[derive(Clone, Debug)]
pub(crate) struct Strips {
    /// First node of each even strip, and the number of nodes in even strips.
    pub even: Vec<usize>,
    /// First node of each odd strip, and the number of nodes.
    pub odd: Vec<usize>,
}

impl Strips {
    /// Sorts nodes into strips so thick that nodes couple with those of neighbouring strips only;
    /// `reach` is how many lines a coupling spans in each direction. Returns where each node stood.
    pub(crate) fn sort(index: &[[u32; 3]], reach: [u32; 3], periodic: [Option<u32>; 3]) -> (Self, Vec<usize>) {
        let mut extent = [1; 3];
        for index in index {
            for d in 0..3 {
                extent[d] = extent[d].max(index[d] + 1);
            }
        }
        // Strips round a closed direction would meet.
        let along = (0..3).filter(|&d| periodic[d].is_none()).max_by_key(|&d| (extent[d], d)).unwrap_or(0);
        let thickness = if periodic[along].is_some() {
            extent[along]
        } else {
            reach[along].max(extent[along].div_ceil(MOST))
        };
        let strip = |node: usize| index[node][along] / thickness.max(1);
        let key = |node: &usize| {
            let [x, y, z] = index[*node];
            (strip(*node) % 2, strip(*node), z, y, x)
        };
        let order = if index.is_sorted_by_key(|[x, y, z]| (z, y, x)) {
            // Nodes of a strip stay in their order.
            let n_strips = extent[along].div_ceil(thickness.max(1)) as usize;
            let mut strips: Vec<Vec<usize>> = vec![Vec::new(); n_strips];
            (0..index.len()).for_each(|node| strips[strip(node) as usize].push(node));
            let even = strips.iter().step_by(2);
            even.chain(strips.iter().skip(1).step_by(2)).flatten().copied().collect()
        } else {
            let mut order: Vec<usize> = (0..index.len()).collect();
            order.sort_by_cached_key(key);
            order
        };

        let (mut even, mut odd) = (Vec::new(), Vec::new());
        let mut last = None;
        for (place, &node) in order.iter().enumerate() {
            if last != Some(strip(node)) {
                last = Some(strip(node));
                if strip(node) % 2 == 0 { even.push(place) } else { odd.push(place) }
            }
        }
        let n_even = odd.first().copied().unwrap_or(order.len());
        even.push(n_even);
        odd.push(order.len());
        (Self { even, odd }, order)
    }

    /// Number of nodes in even strips; these come first.
    pub(crate) fn n_even(&self) -> usize {
        self.even.last().copied().unwrap_or(0)
    }
}
