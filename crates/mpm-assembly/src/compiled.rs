//! The contributions of this crate as the solver knows them, in the plane and in space compiled once, in this crate.
//!
//! A generic type is compiled anew by every crate that makes a trait object of it. Only those of other dimensions are.

use crate::contact::ToolContact;
use crate::contribution::Contribution;
use crate::ghost::GhostStabilisation;
use crate::markers::{MarkerLoad, WallContact};
use std::any::Any;

/// The same value by another name of its type.
fn same<A: Any, B: Any>(value: A) -> B {
    let value: Box<dyn Any> = Box::new(value);
    *value.downcast().expect("the types have the same number of dimensions")
}

macro_rules! compiled_here {
    ($($type:ident),*) => {
        $(impl<const D: usize> From<$type<D>> for Box<dyn Contribution<D>> {
            fn from(it: $type<D>) -> Self {
                #[inline(never)]
                fn plane(it: $type<2>) -> Box<dyn Contribution<2>> {
                    Box::new(it)
                }
                #[inline(never)]
                fn solid(it: $type<3>) -> Box<dyn Contribution<3>> {
                    Box::new(it)
                }
                // What a constant rules out is not compiled.
                if const { D == 2 } {
                    same(plane(same(it)))
                } else if const { D == 3 } {
                    same(solid(same(it)))
                } else {
                    Box::new(it)
                }
            }
        })*
    };
}

compiled_here!(GhostStabilisation, MarkerLoad, ToolContact, WallContact);
