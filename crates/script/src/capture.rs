//! Captured variables: what they were when the script ended, and putting that back.
//!
//! A closure holds what it captures as shared cells, in the list of its curried arguments. The
//! cells are walked once, through nested arrays, maps and closures, and the value of each is kept;
//! before each frame every cell gets its value back. A large array of handles that no function can
//! change is left alone, so that a frame costs what it changes.

use crate::guard::NESTING;
use crate::handle::Handle;
use crate::mutation::may_change;
use crate::trouble::Trouble;
use rhai::{AST, Dynamic, FnPtr};
use std::collections::HashMap;

/// How many closures may capture each other in a row.
const CHAIN: usize = 10_000;

/// One captured variable.
struct Cell {
    /// The shared cell itself.
    cell: Dynamic,
    /// Its value when the script ended.
    saved: Dynamic,
}

/// All captured variables that can be reached from some roots.
#[derive(Default)]
pub(crate) struct Captured {
    cells: Vec<Cell>,
}

impl Captured {
    /// Walks from the roots and keeps the value of every cell.
    pub fn walk<'a>(ast: &AST, roots: impl Iterator<Item = &'a Dynamic>) -> Result<Self, Trouble> {
        let mut walk = Walk::default();
        for root in roots {
            walk.value(root, 0, 0)?;
        }
        let mut cells = Vec::new();
        while let Some((address, cell, links)) = walk.waiting.pop() {
            let saved = cell.flatten_clone();
            walk.value(&saved, 0, links)?;
            cells.push((address, Cell { cell, saved }));
        }
        cells.retain(|(address, cell)| {
            let holders = walk.holders.get(address).map_or(&[][..], Vec::as_slice);
            !large(&cell.saved) || holders.iter().any(|(f, at)| may_change(ast, f, *at))
        });
        Ok(Self { cells: cells.into_iter().map(|(_, cell)| cell).collect() })
    }

    /// Writes every value back.
    pub fn restore(&mut self) {
        for Cell { cell, saved } in &mut self.cells {
            if let Some(mut value) = cell.write_lock::<Dynamic>() {
                put_back(&mut value, saved);
            }
        }
    }
}

/// Whether a value is a large array of nothing but handles.
fn large(value: &Dynamic) -> bool {
    let is_handle = |item: &Dynamic| item.is::<Handle>();
    value.as_array_ref().is_ok_and(|array| array.len() > 256 && array.iter().all(is_handle))
}

/// The walk: cells still to be looked into, each with its address and the number of closures on
/// the way to it; and who holds each cell, as which of its captured variables.
#[derive(Default)]
struct Walk {
    waiting: Vec<(usize, Dynamic, usize)>,
    holders: HashMap<usize, Vec<(FnPtr, usize)>>,
}

impl Walk {
    fn value(&mut self, value: &Dynamic, depth: usize, links: usize) -> Result<(), Trouble> {
        if depth > NESTING {
            return Err(Trouble::new(format!(
                "arrays and maps stand in each other deeper than {NESTING}"
            )));
        }
        if links > CHAIN {
            return Err(Trouble::new(format!(
                "closures capture each other in a chain longer than {CHAIN}"
            )));
        }
        if value.is_shared() {
            self.cell(value, links);
        } else if let Ok(array) = value.as_array_ref() {
            for item in array.iter() {
                self.value(item, depth + 1, links)?;
            }
        } else if let Ok(map) = value.as_map_ref() {
            for item in map.values() {
                self.value(item, depth + 1, links)?;
            }
        } else if let Some(function) = value.read_lock::<FnPtr>() {
            for (at, item) in function.curry().iter().enumerate() {
                if let Some(address) = self.cell(item, links + 1) {
                    self.holders.entry(address).or_default().push((function.clone(), at));
                } else {
                    self.value(item, depth + 1, links + 1)?;
                }
            }
        }
        Ok(())
    }

    /// Notes a shared cell to be looked into, once; its address, if it is one.
    fn cell(&mut self, value: &Dynamic, links: usize) -> Option<usize> {
        if !value.is_shared() {
            return None;
        }
        let address = std::ptr::from_ref(&*value.read_lock::<Dynamic>()?) as usize;
        if let std::collections::hash_map::Entry::Vacant(vacant) = self.holders.entry(address) {
            vacant.insert(Vec::new());
            self.waiting.push((address, value.clone(), links));
        }
        Some(address)
    }
}

/// Makes `to` the same as `saved`, touching only what differs: an array of a million handles that
/// did not change is compared, not made anew.
fn put_back(to: &mut Dynamic, saved: &Dynamic) {
    if let (Ok(mut now), Ok(then)) = (to.as_array_mut(), saved.as_array_ref())
        && now.len() == then.len()
    {
        now.iter_mut().zip(then.iter()).for_each(|(now, then)| put_back(now, then));
        return;
    }
    if let (Ok(mut now), Ok(then)) = (to.as_map_mut(), saved.as_map_ref())
        && now.len() == then.len()
        && now.keys().zip(then.keys()).all(|(now, then)| now == then)
    {
        now.values_mut().zip(then.values()).for_each(|(now, then)| put_back(now, then));
        return;
    }
    if !same(to, saved) {
        *to = saved.clone();
    }
}

/// Whether two plain values are the same, by bits.
fn same(a: &Dynamic, b: &Dynamic) -> bool {
    if let (Some(a), Some(b)) = (a.read_lock::<Handle>(), b.read_lock::<Handle>()) {
        return *a == *b;
    }
    if let (Ok(a), Ok(b)) = (a.as_int(), b.as_int()) {
        return a == b;
    }
    if let (Ok(a), Ok(b)) = (a.as_float(), b.as_float()) {
        return a.to_bits() == b.to_bits();
    }
    false
}
