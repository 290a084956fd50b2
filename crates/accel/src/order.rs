//! The children of a node that a ray meets, brought into an order and packed, in registers.
//!
//! A node holds for each octant of directions the order in which rays of that octant had best visit
//! its children: by the places of their centres. It needs no comparison of entries, and rays visit
//! hardly more nodes by it. (Garanzha and Loop, "Fast Ray Sorting and Breadth-First Packet Traversal
//! for GPU Ray Tracing", 2010, order by octants, too.)

use crate::lanes::{F, LANES, M};
use fearless_simd::prelude::*;

/// Lanes that are packed, and how many; all above are anything.
pub struct Packed {
    /// Where children are entered, by its bits.
    pub entries: [u32; LANES],
    /// What they are.
    pub children: [u32; LANES],
    /// How many are met.
    pub count: u32,
}

/// An order of eight lanes, three bits each, the first lowest.
pub type Order = u32;

/// The orders of the eight octants for boxes with such centres, or twice these, the farthest first.
/// Bit k of an octant says that directions are negative along axis k.
pub fn orders(centers: &[[f32; LANES]; 3]) -> [Order; LANES] {
    let mut orders = [0; LANES];
    for octant in 0..LANES / 2 {
        let mut far = [0; LANES];
        for (lane, far) in far.iter_mut().enumerate() {
            let along = |k: usize| {
                let center = centers[k][lane];
                if octant >> k & 1 == 1 { -center } else { center }
            };
            *far = as_ordered(along(0) + along(1) + along(2));
        }
        // How many come before each: nothing is to be predicted, as when they are sorted.
        let mut ranks = [0; LANES];
        for (lane, rank) in ranks.iter_mut().enumerate() {
            for other in 0..LANES {
                let before =
                    if other < lane { far[other] >= far[lane] } else { far[other] > far[lane] };
                *rank += u32::from(before);
            }
        }
        let last = LANES as u32 - 1;
        for (lane, rank) in ranks.into_iter().enumerate() {
            orders[octant] |= (lane as Order) << (3 * rank);
            orders[LANES - 1 - octant] |= (lane as Order) << (3 * (last - rank));
        }
    }
    orders
}

/// A number that is ordered as [`f32::total_cmp`] orders these.
fn as_ordered(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    bits ^ (bits >> 31) & i32::MAX
}

/// Packs those lanes of `entry` and `children` that are met, in an order.
#[inline(always)]
pub fn pack<S: Simd>(
    simd: S,
    entry: F<S>,
    met: M<S>,
    children: &[u32; LANES],
    order: Order,
) -> Packed {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = simd.level().as_avx2() {
        let mut bits = [0; LANES];
        met.to_vector().store_slice(&mut bits);
        let mut entries = [0; LANES];
        entry.to_bits().store_slice(&mut entries);
        return avx2::pack(avx2, entries, bits, *children, order);
    }
    let _ = simd;
    let (entry, bits) = (entry.to_bits(), met.to_bitmask());
    let entry = entry.as_slice();
    let mut packed = Packed { entries: [0; LANES], children: [0; LANES], count: 0 };
    for i in 0..LANES {
        let lane = (order >> (3 * i)) as usize % LANES;
        let to = packed.count as usize % LANES;
        (packed.entries[to], packed.children[to]) = (entry[lane], children[lane]);
        packed.count += (bits >> lane) as u32 & 1;
    }
    packed
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod avx2 {
    use super::{LANES, Packed};
    use fearless_simd::{i32x8, prelude::*, u32x8};
    #[cfg(target_arch = "x86")]
    use std::arch::x86::*;
    #[cfg(target_arch = "x86_64")]
    use std::arch::x86_64::*;

    /// For each set of lanes its members, a byte each, in ascending order.
    static MEMBERS: [[u8; LANES]; 256] = {
        let mut members = [[0; LANES]; 256];
        let mut set = 0;
        while set < 256 {
            let (mut lane, mut count) = (0, 0);
            while lane < LANES {
                if set >> lane & 1 == 1 {
                    members[set][count] = lane as u8;
                    count += 1;
                }
                lane += 1;
            }
            set += 1;
        }
        members
    };

    fearless_simd::kernel!(
        #[inline(always)]
        pub fn pack(
            avx2: Avx2,
            entries: [u32; LANES],
            met: [i32; LANES],
            children: [u32; LANES],
            order: u32,
        ) -> Packed {
            let entries: __m256i = u32x8::from_slice(avx2, &entries).into();
            let met: __m256i = i32x8::from_slice(avx2, &met).into();
            let children: __m256i = u32x8::from_slice(avx2, &children).into();
            let shifts = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            // A permutation looks at the three lowest bits of a lane only.
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
            let met = _mm256_permutevar8x32_epi32(met, order);
            let set = _mm256_movemask_ps(_mm256_castsi256_ps(met)) as usize % 256;
            let members = _mm_cvtsi64_si128(i64::from_le_bytes(MEMBERS[set]));
            let members = _mm256_cvtepu8_epi32(members);
            let order = _mm256_permutevar8x32_epi32(order, members);
            let entries: u32x8<_> = _mm256_permutevar8x32_epi32(entries, order).simd_into(avx2);
            let children: u32x8<_> = _mm256_permutevar8x32_epi32(children, order).simd_into(avx2);
            Packed { entries: entries.into(), children: children.into(), count: set.count_ones() }
        }
    );
}
