//! Accessors: typed elements in buffers, plain, sparse or normalised.

use super::Trouble;
use super::container::File;
use super::json::{Accessor, Sparse};

/// Elements that a sparse accessor puts in the place of others: their numbers and their bytes.
type Overrides<'a> = Vec<(u32, &'a [u8])>;

/// The most elements of an accessor that takes them from no buffer.
const MOST_OF_NOTHING: usize = 1 << 24;

/// The types of components, by their numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: u32) -> Option<Component> {
        Some(match number {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// One component as a number; the bytes are as many as it takes.
    fn number(self, bytes: &[u8], normalised: bool) -> f64 {
        let four = *bytes.first_chunk::<4>().unwrap_or(&[0; 4]);
        let two = *bytes.first_chunk::<2>().unwrap_or(&[0; 2]);
        let one = bytes.first().copied().unwrap_or(0);
        let (number, most): (f64, f64) = match self {
            Component::I8 => ((one as i8).into(), 127.0),
            Component::U8 => (one.into(), 255.0),
            Component::I16 => (i16::from_le_bytes(two).into(), 32767.0),
            Component::U16 => (u16::from_le_bytes(two).into(), 65535.0),
            Component::U32 => (u32::from_le_bytes(four).into(), 4_294_967_295.0),
            Component::F32 => return f32::from_le_bytes(four).into(),
        };
        let scaled = if normalised { number / most } else { number };
        // -128 stands for -1, too.
        if normalised && scaled < -1.0 { -1.0 } else { scaled }
    }
}

/// The elements of an accessor, each read when it is asked for.
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
    normalised: bool,
    components: usize,
    /// How many there are.
    pub count: usize,
    /// What stands in place of some of them.
    overrides: Vec<(u32, &'a [u8])>,
}

impl File {
    /// How many elements an accessor has; 0 if there is none.
    pub fn count(&self, accessor: Option<usize>) -> usize {
        accessor.and_then(|index| self.root.accessors.get(index)).map_or(0, |a| a.count)
    }

    /// The elements of accessor `index`, which is `name`, of one of these types.
    pub fn elements(
        &self,
        index: usize,
        name: &str,
        kinds: &[&str],
    ) -> Result<Elements<'_>, Trouble> {
        let accessor = self.root.accessors.get(index).ok_or_else(|| {
            format!("accessor {index} is asked for, there are {}", self.root.accessors.len())
        })?;
        let kind = accessor.kind.as_str();
        if !kinds.contains(&kind) {
            return Err(format!("{name} is a {kind:?}; it must be {}", kinds.join(" or ")).into());
        }
        let components = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let component = Component::of(accessor.component_type);
        let component =
            component.ok_or_else(|| format!("{name} is of numbers that are not read"))?;
        let size = component.size() * components;
        let beyond = || Trouble::Said(format!("accessor {index} reaches beyond its buffer"));
        let (bytes, stride) = match accessor.buffer_view {
            Some(view) => {
                let (bytes, view) = self.view(view)?;
                let stride = view.byte_stride.filter(|stride| *stride > 0).unwrap_or(size);
                let bytes = within(bytes, accessor.byte_offset, (accessor.count, stride, size));
                (bytes.ok_or_else(beyond)?, stride)
            }
            None if accessor.count > MOST_OF_NOTHING => return Err(beyond()),
            None => (&[][..], 0),
        };
        let overrides = match &accessor.sparse {
            Some(sparse) => {
                self.overrides(sparse, accessor, size).and_then(|o| o.ok_or_else(beyond))?
            }
            None => Vec::new(),
        };
        let normalised = accessor.normalized;
        let count = accessor.count;
        Ok(Elements { bytes, stride, component, normalised, components, count, overrides })
    }

    /// The values of a sparse accessor by their indices, ascending; `None` if they reach beyond their
    /// buffers or the accessor.
    fn overrides(
        &self,
        sparse: &Sparse,
        accessor: &Accessor,
        size: usize,
    ) -> Result<Option<Overrides<'_>>, Trouble> {
        let (indices, _) = self.view(sparse.indices.buffer_view)?;
        let (values, _) = self.view(sparse.values.buffer_view)?;
        let Some(kind) = Component::of(sparse.indices.component_type) else { return Ok(None) };
        let width = kind.size();
        let indices = within(indices, sparse.indices.byte_offset, (sparse.count, width, width));
        let values = within(values, sparse.values.byte_offset, (sparse.count, size, size));
        let (Some(indices), Some(values)) = (indices, values) else { return Ok(None) };
        let pairs = indices.chunks_exact(width).zip(values.chunks_exact(size));
        let mut all: Vec<(u32, &[u8])> =
            pairs.map(|(index, value)| (kind.number(index, false) as u32, value)).collect();
        all.sort_by_key(|(index, _)| *index);
        let inside = all.last().is_none_or(|(index, _)| (*index as usize) < accessor.count);
        Ok(inside.then_some(all))
    }
}

/// The bytes of `count` elements, each `stride` after the one before and `size` long.
fn within(
    bytes: &[u8],
    offset: usize,
    (count, stride, size): (usize, usize, usize),
) -> Option<&[u8]> {
    let Some(last) = count.checked_sub(1) else { return Some(&[]) };
    let length = last.checked_mul(stride)?.checked_add(size)?;
    bytes.get(offset..offset.checked_add(length)?)
}

impl Elements<'_> {
    /// Element `i`, or its first `N` numbers; zeros beyond the last.
    pub fn get<const N: usize>(&self, i: usize) -> [f64; N] {
        let found = self.overrides.binary_search_by_key(&i, |(index, _)| *index as usize);
        let element = match found {
            Ok(at) => self.overrides[at].1,
            Err(_) => self.bytes.get(i * self.stride..).unwrap_or_default(),
        };
        let mut out = [0.0; N];
        let width = self.component.size();
        for (k, out) in out.iter_mut().enumerate().take(self.components) {
            if let Some(bytes) = element.get(k * width..(k + 1) * width) {
                *out = self.component.number(bytes, self.normalised);
            }
        }
        out
    }

    /// Element `i` as a whole number.
    pub fn index(&self, i: usize) -> u32 {
        self.get::<1>(i)[0] as u32
    }

    /// Whether its numbers are whole, as indices are.
    pub fn is_whole(&self) -> bool {
        matches!(self.component, Component::U8 | Component::U16 | Component::U32)
    }

    /// Whether texture coordinates and colours may be of these numbers: floats, or whole ones that
    /// are normalised.
    pub fn is_real(&self) -> bool {
        self.component == Component::F32 || self.normalised
    }
}
