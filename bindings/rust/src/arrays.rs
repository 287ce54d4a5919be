// SPDX-License-Identifier: MIT
//! Arrays that the library reads or writes where they lie.

use std::alloc::{alloc_zeroed, Layout};
use std::marker::PhantomData;
use std::mem::size_of;

use crate::error::{Error, Result};
use crate::ffi;

mod sealed {
    pub trait Sealed {}
}

/// What an element of an array can be: one or more numbers, next to each other.
pub trait Element: sealed::Sealed + Copy {
    /// The type of these numbers.
    type Scalar: Copy;
}

macro_rules! elements {
    ($($element:ty: $scalar:ty),*) => {
        $(impl sealed::Sealed for $element {}
        impl Element for $element {
            type Scalar = $scalar;
        })*
    };
}

elements!(f32: f32, u32: u32, i32: i32, u8: u8, [f32; 3]: f32, [u32; 3]: u32, [u32; 2]: u32, [u16; 3]: u16);

/// `n` zeros. Without memory for them the answer is an error, where `vec!` would end the process.
pub(crate) fn zeros<T: Element>(n: usize) -> Result<Vec<T>> {
    let fail = || Error::out_of_memory(format!("no memory for {n} results"));
    let layout = Layout::array::<T>(n).map_err(|_| fail())?;
    if n == 0 {
        return Ok(Vec::new());
    }
    // SAFETY: the layout is that of a vector of this capacity, whose size is not 0; all elements are numbers.
    let data = unsafe { alloc_zeroed(layout) }.cast::<T>();
    if data.is_null() {
        return Err(fail());
    }
    Ok(unsafe { Vec::from_raw_parts(data, n, n) })
}

/// An array that the library reads: a slice, elements that lie apart, or one element for all rays.
///
/// Nothing is copied. A `&[T]`, `&Vec<T>` or `&[T; N]` becomes one by `into()`; [`field!`](crate::field) makes one of a
/// field of a slice of structs.
#[derive(Debug)]
pub struct Input<'a, T> {
    data: *const T,
    stride: usize,
    len: usize,
    borrowed: PhantomData<&'a [T]>,
}

// SAFETY: what a shared slice allows.
unsafe impl<T: Sync> Send for Input<'_, T> {}
unsafe impl<T: Sync> Sync for Input<'_, T> {}

impl<T> Clone for Input<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Input<'_, T> {}

impl<'a, T: Element> Input<'a, T> {
    /// One element that serves all rays: a common origin, direction, limit and so on.
    pub fn all(value: &'a T) -> Self {
        Input { data: value, stride: ffi::MLRT_STRIDE_ALL, len: usize::MAX, borrowed: PhantomData }
    }

    /// Elements that begin every `step` numbers of `numbers`: the columns of a matrix, or vectors with padding.
    ///
    /// As many as lie in the slice wholly. Panics if `step` is 0.
    pub fn strided(numbers: &'a [T::Scalar], step: usize) -> Self {
        assert!(step > 0, "a step of 0");
        let width = size_of::<T>() / size_of::<T::Scalar>();
        let len = if numbers.len() < width { 0 } else { (numbers.len() - width) / step + 1 };
        // Beyond all slices, but not the stride of one element for all.
        let stride = step.saturating_mul(size_of::<T::Scalar>()).min(isize::MAX as usize);
        Input { data: numbers.as_ptr().cast(), stride, len, borrowed: PhantomData }
    }

    /// `len` elements, `stride` bytes apart.
    ///
    /// # Safety
    ///
    /// All of them can be read for as long as `'a`, and are not written meanwhile.
    pub unsafe fn from_raw(data: *const T, stride: usize, len: usize) -> Self {
        Input { data, stride, len, borrowed: PhantomData }
    }

    /// The number of elements; `usize::MAX` if one serves all.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Is there no element?
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub(crate) fn is_all(&self) -> bool {
        self.stride == ffi::MLRT_STRIDE_ALL
    }

    pub(crate) fn pointer(&self) -> *const T {
        self.data
    }

    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    /// As an array of `len` elements of the C interface.
    pub(crate) fn array(&self, name: &str, len: usize) -> Result<ffi::mlrt_const_array> {
        if !self.is_all() && self.len != len {
            return Err(Error::argument(format!("{name}: {} elements, where {len} are needed", self.len)));
        }
        Ok(ffi::mlrt_const_array { data: self.data.cast(), stride: self.stride })
    }
}

impl<'a, T: Element> From<&'a [T]> for Input<'a, T> {
    fn from(slice: &'a [T]) -> Self {
        Input { data: slice.as_ptr(), stride: 0, len: slice.len(), borrowed: PhantomData }
    }
}

impl<'a, T: Element> From<&'a Vec<T>> for Input<'a, T> {
    fn from(vector: &'a Vec<T>) -> Self {
        vector.as_slice().into()
    }
}

impl<'a, T: Element, const N: usize> From<&'a [T; N]> for Input<'a, T> {
    fn from(array: &'a [T; N]) -> Self {
        array.as_slice().into()
    }
}

/// The field of all structs of a slice, as an [`Input`]: `field!(&vertices, Vertex, position)`.
///
/// ```
/// struct Vertex { normal: [f32; 3], position: [f32; 3] }
/// let vertices = [Vertex { normal: [0.; 3], position: [1., 2., 3.] }];
/// let positions: mlrt::Input<[f32; 3]> = mlrt::field!(&vertices, Vertex, position);
/// assert_eq!(positions.len(), 1);
/// ```
///
/// The field itself must be an element, not something that points to one:
///
/// ```compile_fail,E0308
/// struct Vertex { position: Box<[f32; 3]>, name: [u8; 16] }
/// let vertices: Vec<Vertex> = Vec::new();
/// let positions: mlrt::Input<[f32; 3]> = mlrt::field!(&vertices, Vertex, position);
/// ```
///
/// Nor can it be a field of a union:
///
/// ```compile_fail,E0133
/// union Vertex { position: [f32; 3], name: [u8; 16] }
/// let vertices: Vec<Vertex> = Vec::new();
/// let positions: mlrt::Input<[f32; 3]> = mlrt::field!(&vertices, Vertex, position);
/// ```
#[macro_export]
macro_rules! field {
    ($slice:expr, $struct:ty, $field:ident) => {{
        let slice: &[$struct] = &$slice[..];
        // It does not compile if the field is not there, or is of a union, which may hold anything. A pointer has exactly
        // the type of the field, where a reference could be to what a Box points to.
        let field = |s: &$struct| {
            let field = &s.$field;
            ::std::ptr::addr_of!(*field)
        };
        // SAFETY: the field is at this offset in each struct.
        unsafe { $crate::field_at(slice, ::std::mem::offset_of!($struct, $field), field) }
    }};
}

/// For [`field!`].
///
/// # Safety
///
/// In each struct a field of the type to which `_field` returns a pointer lies at `offset`.
#[doc(hidden)]
pub unsafe fn field_at<'a, S, T: Element>(slice: &'a [S], offset: usize, _field: fn(&S) -> *const T) -> Input<'a, T> {
    assert!(offset + size_of::<T>() <= size_of::<S>());
    let data = slice.as_ptr().cast::<u8>().wrapping_add(offset).cast();
    Input { data, stride: size_of::<S>(), len: slice.len(), borrowed: PhantomData }
}

/// An array that the library writes: a slice, or elements that lie apart.
///
/// A `&mut [T]` or `&mut Vec<T>` becomes one by `into()`.
#[derive(Debug)]
pub struct Output<'a, T> {
    data: *mut T,
    stride: usize,     // in bytes
    row_stride: usize, // in bytes; 0 = packed
    size: usize,       // bytes from `data` on
    borrowed: PhantomData<&'a mut [T]>,
}

// SAFETY: what an exclusive slice allows.
unsafe impl<T: Send> Send for Output<'_, T> {}
unsafe impl<T: Sync> Sync for Output<'_, T> {}

impl<'a, T: Element> Output<'a, T> {
    /// Elements that begin every `step` numbers of `numbers`, and rows of pixels every `row_step` numbers (0: rows follow
    /// each other; calls for rays have one row). Panics if `step` is 0.
    pub fn strided(numbers: &'a mut [T::Scalar], step: usize, row_step: usize) -> Self {
        assert!(step > 0, "a step of 0");
        let scalar = size_of::<T::Scalar>();
        Output {
            data: numbers.as_mut_ptr().cast(),
            stride: step.saturating_mul(scalar),
            row_stride: row_step.saturating_mul(scalar),
            size: std::mem::size_of_val(numbers),
            borrowed: PhantomData,
        }
    }

    /// A field of structs that no other Output has.
    pub(crate) fn field(data: *mut T, stride: usize, size: usize) -> Self {
        Output { data, stride, row_stride: 0, size, borrowed: PhantomData }
    }

    /// Do elements of different rows share bytes? Rows may lie within each other, as those of a transposed picture do.
    /// There must be space for all.
    fn rows_overlap(&self, columns: usize, rows: usize) -> bool {
        if columns == 0 || rows < 2 || self.row_stride == 0 || self.row_stride >= columns * self.stride {
            return false;
        }
        (1..rows).map(|row| row * self.row_stride).take_while(|start| *start < columns * self.stride).any(|start| {
            let (column, rest) = (start / self.stride, start % self.stride);
            column < columns && rest < size_of::<T>() || column + 1 < columns && self.stride - rest < size_of::<T>()
        })
    }

    /// As an array of rows of the C interface.
    pub(crate) fn array(&mut self, name: &str, columns: usize, rows: usize) -> Result<ffi::mlrt_array> {
        let row_stride = if self.row_stride == 0 { columns.checked_mul(self.stride) } else { Some(self.row_stride) };
        let needed = || {
            let last_row = (rows - 1).checked_mul(row_stride?)?;
            last_row.checked_add((columns - 1).checked_mul(self.stride)?)?.checked_add(size_of::<T>())
        };
        if columns > 0 && rows > 0 && needed().map_or(true, |needed| needed > self.size) {
            return Err(Error::argument(format!("{name}: too short for {rows} rows of {columns} results")));
        }
        if self.rows_overlap(columns, rows) {
            let step = self.row_stride / size_of::<T::Scalar>();
            return Err(Error::argument(format!(
                "{name}: rows of {columns} results overlap with a row step of {step}"
            )));
        }
        Ok(ffi::mlrt_array { data: self.data.cast(), stride: self.stride, row_stride: self.row_stride })
    }
}

impl<'a, T: Element> From<&'a mut [T]> for Output<'a, T> {
    fn from(slice: &'a mut [T]) -> Self {
        let size = std::mem::size_of_val(slice);
        Output { data: slice.as_mut_ptr(), stride: size_of::<T>(), row_stride: 0, size, borrowed: PhantomData }
    }
}

impl<'a, T: Element> From<&'a mut Vec<T>> for Output<'a, T> {
    fn from(vector: &'a mut Vec<T>) -> Self {
        vector.as_mut_slice().into()
    }
}
