//! Passes over the tree of fronts, in parallel where subtrees do not depend on each other.
//!
//! Subtrees of little work are tasks, within which fronts are visited one after the other; the fronts above them are
//! visited once their children are. The cut depends on the matrix only, and every sum is made in an order that the
//! tree gives, so the number of threads changes no bit.

use super::fronts::Fronts;
use rayon::prelude::*;
use std::ops::Range;

/// Multiplications of a task, at least: some 0.2 ms.
const LEAST_WORK: f64 = 1e6;

/// Tasks have at least this part of the work of the whole tree.
const LEAST_SHARE: f64 = 1.0 / 256.0;

/// What belongs to a sequence of fronts, and is divided as they are.
pub(super) trait Part: Sized + Send {
    /// Divides it after so many numbers of fronts and steps of elimination.
    fn split(self, numbers: usize, steps: usize) -> (Self, Self);
}

impl Part for &mut [f64] {
    /// A number for each step.
    fn split(self, _: usize, steps: usize) -> (Self, Self) {
        self.split_at_mut(steps)
    }
}

/// A pass from children to parents. What a front hands on goes to its parent; None ends the pass.
pub(super) trait Upward: Sync {
    type Part: Part;

    /// Visits the fronts of a few subtrees one after the other; returns what the last front hands on.
    fn subtrees(&self, fronts: Range<usize>, part: Self::Part) -> Option<Vec<f64>>;

    /// Visits a front with what its children have handed on.
    fn front(&self, k: usize, part: Self::Part, children: Vec<Vec<f64>>) -> Option<Vec<f64>>;
}

/// A pass from parents to children.
pub(super) trait Downward: Sync {
    type Part: Part;

    /// Visits the fronts of a few subtrees one after the other with what the last front's parent hands on to it.
    fn subtrees(&self, fronts: Range<usize>, part: Self::Part, given: Vec<f64>);

    /// Visits a front with what its parent hands on to it; returns what it hands on to its children.
    fn front(&self, k: usize, part: Self::Part, given: Vec<f64>) -> Vec<Vec<f64>>;
}

/// A subtree, or a few that lie next to each other, and what belongs to it.
struct Task<P> {
    fronts: Range<usize>,
    part: P,
}

impl Fronts {
    /// Work of the smallest subtrees that are divided.
    fn cut(&self) -> f64 {
        let total: f64 = self.roots().iter().map(|&root| self.fronts[root].work).sum();
        LEAST_WORK.max(LEAST_SHARE * total)
    }

    /// Fronts without a parent.
    fn roots(&self) -> Vec<usize> {
        let mut roots = Vec::new();
        let mut end = self.fronts.len();
        while end > 0 {
            roots.push(end - 1);
            end = self.fronts[end - 1].first;
        }
        roots.reverse();
        roots
    }

    /// Takes what belongs to fronts up to `end` off what belongs to those from `begin` on.
    fn take<P: Part>(&self, begin: usize, end: usize, part: P) -> (P, P) {
        let (first, last) = (&self.fronts[begin], &self.fronts[end - 1]);
        part.split(last.numbers().end - first.start, last.steps.end - first.steps.start)
    }

    /// The roots as tasks, small ones in groups.
    fn forest<P: Part>(&self, cut: f64, mut part: P) -> Vec<Task<P>> {
        let (mut tasks, mut begin, mut work) = (Vec::new(), 0, 0.0);
        let roots = self.roots();
        for (k, &root) in roots.iter().enumerate() {
            work += self.fronts[root].work;
            let is_last_of_group = roots.get(k + 1).is_none_or(|&next| work + self.fronts[next].work > cut);
            if is_last_of_group {
                let (own, rest) = self.take(begin, root + 1, part);
                tasks.push(Task { fronts: begin..root + 1, part: own });
                (part, begin, work) = (rest, root + 1, 0.0);
            }
        }
        tasks
    }

    /// Divides what belongs to the subtree of a front into that of its children and its own.
    fn below<P: Part>(&self, k: usize, mut part: P) -> (Vec<Task<P>>, P) {
        let mut begin = self.fronts[k].first;
        let mut tasks = Vec::with_capacity(self.children(k).len());
        for &child in self.children(k) {
            let (own, rest) = self.take(begin, child + 1, part);
            tasks.push(Task { fronts: begin..child + 1, part: own });
            (part, begin) = (rest, child + 1);
        }
        (tasks, part)
    }

    /// The only child of a front that is divided, if the others are less than a task.
    fn heir(&self, k: usize, cut: f64) -> Option<usize> {
        let children = self.children(k);
        let work = |&child: &usize| self.fronts[child].work;
        let heir = (0..children.len()).find(|&place| work(&children[place]) > cut)?;
        let others: f64 = children.iter().map(work).sum::<f64>() - work(&children[heir]);
        (others <= cut).then_some(heir)
    }

    /// Numbers of the remainders that are kept at one time in a factorisation, on any number of threads: at most.
    pub(super) fn most_remainders(&self) -> usize {
        let cut = self.cut();
        // Of each subtree.
        let mut most = vec![0; self.fronts.len()];
        for (k, front) in self.fronts.iter().enumerate() {
            let children = self.children(k).iter();
            let handed_on: usize = children.clone().map(|&child| self.fronts[child].n_remainder()).sum();
            let own = handed_on + front.n_remainder();
            let below = children.map(|&child| most[child]);
            most[k] = if front.work > cut {
                below.sum::<usize>().max(own)
            } else {
                // Fronts are visited one after the other, with the remainders of those before.
                let mut before = 0;
                let sizes = self.children(k).iter().map(|&child| self.fronts[child].n_remainder());
                below.zip(sizes).fold(own, |most, (below, size)| {
                    before += size;
                    most.max(before - size + below)
                })
            };
        }
        self.roots().iter().map(|&root| most[root]).sum()
    }

    /// Makes a pass from the leaves to the roots; None where a front ends it.
    pub(super) fn upward<U: Upward>(&self, pass: &U, part: U::Part) -> Option<()> {
        let cut = self.cut();
        let done = in_parallel(self.forest(cut, part), |task| self.climb(pass, cut, task));
        done.iter().all(Option::is_some).then_some(())
    }

    fn climb<U: Upward>(&self, pass: &U, cut: f64, task: Task<U::Part>) -> Option<Vec<f64>> {
        let Task { fronts, mut part } = task;
        let mut k = fronts.end - 1;
        if self.fronts[k].first != fronts.start || self.fronts[k].work <= cut {
            return pass.subtrees(fronts, part);
        }
        // A chain of fronts is followed here, so that the depth of recursion is bounded by the number of tasks.
        let mut chain = Vec::new();
        let (tasks, mut own) = loop {
            let (mut tasks, own) = self.below(k, part);
            let Some(heir) = self.heir(k, cut) else {
                break (tasks, own);
            };
            let next = tasks.remove(heir);
            chain.push((k, own, heir, tasks));
            k = next.fronts.end - 1;
            part = next.part;
        };
        let mut children = in_parallel(tasks, |task| self.climb(pass, cut, task));
        loop {
            let handed_on = pass.front(k, own, children.into_iter().collect::<Option<_>>()?);
            let Some((parent, its_own, heir, others)) = chain.pop() else {
                return handed_on;
            };
            children = others.into_iter().map(|task| pass.subtrees(task.fronts, task.part)).collect();
            children.insert(heir, handed_on);
            (k, own) = (parent, its_own);
        }
    }

    /// Makes a pass from the roots to the leaves.
    pub(super) fn downward<T: Downward>(&self, pass: &T, part: T::Part) {
        let cut = self.cut();
        in_parallel(self.forest(cut, part), |task| self.descend(pass, cut, task, Vec::new()));
    }

    fn descend<T: Downward>(&self, pass: &T, cut: f64, task: Task<T::Part>, mut given: Vec<f64>) {
        let Task { mut fronts, mut part } = task;
        loop {
            let k = fronts.end - 1;
            if self.fronts[k].first != fronts.start || self.fronts[k].work <= cut {
                return pass.subtrees(fronts, part, given);
            }
            let (tasks, own) = self.below(k, part);
            let handed_on = pass.front(k, own, given);
            let mut tasks: Vec<_> = tasks.into_iter().zip(handed_on).collect();
            let Some(heir) = self.heir(k, cut) else {
                in_parallel(tasks, |(task, given)| self.descend(pass, cut, task, given));
                return;
            };
            let next = tasks.remove(heir);
            tasks.into_iter().for_each(|(task, given)| pass.subtrees(task.fronts, task.part, given));
            (fronts, part, given) = (next.0.fronts, next.0.part, next.1);
        }
    }
}

/// Does all tasks; the results stand in the sequence of these.
fn in_parallel<T: Send, R: Send>(tasks: Vec<T>, work: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    if tasks.len() < 2 {
        return tasks.into_iter().map(work).collect();
    }
    tasks.into_par_iter().with_max_len(1).map(work).collect()
}
