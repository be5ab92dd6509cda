//! Numbers of the nodes of all ranks: those of a rank behind those of lower ranks.

use mpm_cluster::Wire;

/// Order of nodes among themselves: as lattices number them.
fn key(index: &[u32; 3]) -> [u32; 3] {
    [index[2], index[1], index[0]]
}

/// Who has which nodes of a list that every rank has for itself.
pub(crate) struct Numbering {
    /// Nodes of this rank, in order.
    pub(crate) own: Vec<[u32; 3]>,
    /// Number of its first node.
    pub(crate) first: usize,
    /// Nodes of all ranks.
    pub(crate) total: usize,
    /// Number of every node of the list.
    pub(crate) number: Vec<u64>,
    /// Of other ranks that have own nodes in their list: places among own nodes, in the order of their list.
    asked: Vec<(usize, Vec<u32>)>,
    /// Of owners of listed nodes: their places in the list, in its order.
    asking: Vec<(usize, Vec<u32>)>,
}

impl Numbering {
    /// Numbers the nodes of all lists. An owner has all of its nodes, also those that stand in the lists of others only.
    pub(crate) fn of(wire: &dyn Wire, list: &[[u32; 3]], owner: impl Fn([u32; 3]) -> usize) -> Self {
        let mut asking: Vec<(usize, Vec<u32>)> = (0..wire.size()).map(|rank| (rank, Vec::new())).collect();
        for (place, index) in list.iter().enumerate() {
            asking[owner(*index)].1.push(place as u32);
        }
        asking.retain(|it| !it.1.is_empty());
        let indices = |places: &[u32]| {
            places.iter().flat_map(|&it| list[it as usize]).flat_map(u32::to_le_bytes).collect::<Vec<u8>>()
        };
        let out: Vec<(usize, Vec<u8>)> = asking.iter().map(|(rank, it)| (*rank, indices(it))).collect();
        let wanted: Vec<(usize, Vec<[u32; 3]>)> =
            wire.exchange(&out).into_iter().map(|(rank, bytes)| (rank, read_indices(&bytes))).collect();
        let mut own: Vec<[u32; 3]> = wanted.iter().flat_map(|it| it.1.iter().copied()).collect();
        own.sort_unstable_by_key(key);
        own.dedup();

        let mut counts = vec![0.0; wire.size()];
        wire.gather(&[own.len() as f64], &mut counts);
        let first = counts[..wire.rank()].iter().sum::<f64>() as usize;
        let total = counts.iter().sum::<f64>() as usize;
        let place = |it: &[u32; 3]| own.binary_search_by_key(&key(it), key).expect("it is among them") as u32;
        let asked: Vec<(usize, Vec<u32>)> =
            wanted.iter().map(|(rank, list)| (*rank, list.iter().map(place).collect())).collect();
        let mut numbering = Self { first, total, own, asked, asking, number: vec![0; list.len()] };
        let numbers: Vec<u64> = (0..numbering.own.len()).map(|k| (first + k) as u64).collect();
        let mut number = std::mem::take(&mut numbering.number);
        numbering.spread(
            wire,
            1,
            |k, _| f64::from_bits(numbers[k]),
            |place, _, it| number[place] = it.to_bits(),
        );
        numbering.number = number;
        numbering
    }

    /// Tells all who have a node in their list what its owner knows: `width` numbers each, by the place among own
    /// nodes and component, to the place in the list and component.
    pub(crate) fn spread(
        &self,
        wire: &dyn Wire,
        width: usize,
        of: impl Fn(usize, usize) -> f64,
        mut see: impl FnMut(usize, usize, f64),
    ) {
        let message = |places: &[u32]| {
            let values = places.iter().flat_map(|&k| (0..width).map(move |i| (k as usize, i)));
            values.flat_map(|(k, i)| of(k, i).to_bits().to_le_bytes()).collect::<Vec<u8>>()
        };
        let out: Vec<(usize, Vec<u8>)> = self.asked.iter().map(|(rank, it)| (*rank, message(it))).collect();
        for ((from, bytes), (rank, places)) in wire.exchange(&out).into_iter().zip(&self.asking) {
            assert_eq!(from, *rank, "owners answer in the order of the ranks");
            let mut values = bytes.as_chunks().0.iter().map(|it| f64::from_bits(u64::from_le_bytes(*it)));
            for &place in places {
                (0..width).for_each(|i| see(place as usize, i, values.next().expect("a number for each")));
            }
        }
    }

    /// The bits of every node of the list that are set on any rank which lists it; returns those of own nodes.
    pub(crate) fn unite(&self, wire: &dyn Wire, bits: &mut [u8]) -> Vec<u8> {
        let message = |places: &[u32]| places.iter().map(|&place| bits[place as usize]).collect::<Vec<u8>>();
        let out: Vec<(usize, Vec<u8>)> = self.asking.iter().map(|(rank, it)| (*rank, message(it))).collect();
        let mut own = vec![0; self.own.len()];
        for ((_, bytes), (_, places)) in wire.exchange(&out).iter().zip(&self.asked) {
            places.iter().zip(bytes).for_each(|(&k, byte)| own[k as usize] |= byte);
        }
        self.spread(wire, 1, |k, _| f64::from(own[k]), |place, _, it| bits[place] = it as u8);
        own
    }

    /// Of every own node of the finest list: its place there.
    pub(crate) fn places_of_own(&self, n: usize) -> Vec<usize> {
        let mut places = vec![usize::MAX; self.own.len()];
        for place in 0..n {
            let own = (self.number[place] as usize).checked_sub(self.first).filter(|k| *k < places.len());
            if let Some(own) = own {
                places[own] = place;
            }
        }
        places
    }
}

fn read_indices(bytes: &[u8]) -> Vec<[u32; 3]> {
    let numbers: Vec<u32> = bytes.as_chunks().0.iter().map(|it| u32::from_le_bytes(*it)).collect();
    numbers.as_chunks().0.to_vec()
}
