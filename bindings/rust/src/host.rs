// SPDX-License-Identifier: MIT
//! Memory, messages and progress: what a program can provide to a call.

use std::alloc::Layout;
use std::any::Any;
use std::ffi::{c_char, c_void, CStr};
use std::ops::ControlFlow;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex};

use crate::ffi;

/// Where the memory of trees, pools and calls comes from.
///
/// # Safety
///
/// `allocate` returns NULL, or a block that fits the layout and is not used for anything else until it is freed.
pub unsafe trait Memory: Send + Sync {
    /// A block of this layout, whose size is not 0; NULL if there is none. Several threads may call it at once. It must not
    /// use the pool of the call.
    fn allocate(&self, layout: Layout) -> *mut u8;

    /// Frees a block.
    ///
    /// # Safety
    ///
    /// `allocate` returned the block for this layout, and it is not used any more.
    unsafe fn free(&self, block: *mut u8, layout: Layout);
}

/// The kinds of messages that a [`Host`] receives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Level {
    /// The reason why a call fails.
    Error,
    /// Something was left out.
    Warning,
    /// A tree was built, its size and time; or the host stopped a call.
    Info,
}

/// Receives the part of a call that is done, 0 to 1, every few milliseconds; `Break` cancels the call.
///
/// The threads of the pool call it, one at a time. It must not use the pool of the call, unless that pool has an executor.
pub type Progress<'a> = dyn Fn(f64) -> ControlFlow<()> + Sync + 'a;

/// Receives messages, on the thread of the call.
pub type Log<'a> = dyn Fn(Level, &str) + Sync + 'a;

/// What the program provides to a call. A panic in `progress` cancels the call; that panic, and one in `log`, go on when the
/// call has returned. A panic in [`Memory::allocate`] counts as no memory, one in [`Memory::free`] is dropped.
#[derive(Clone, Default)]
pub struct Host<'a> {
    /// Memory, for the call and for the tree that it makes; `None`: malloc.
    pub memory: Option<Arc<dyn Memory>>,
    /// Receives messages.
    pub log: Option<&'a Log<'a>>,
    /// Hears how far the call is, and can cancel it.
    pub progress: Option<&'a Progress<'a>>,
}

impl std::fmt::Debug for Host<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Host {{ memory: {}, log: {}, ", self.memory.is_some(), self.log.is_some())?;
        write!(f, "progress: {} }}", self.progress.is_some())
    }
}

/// What the `user` of an `mlrt_host` points to. A tree with memory of its own keeps it.
pub(crate) struct Keeper {
    memory: Option<Arc<dyn Memory>>,
    call: AtomicPtr<Call<'static>>, // NULL between calls
}

/// The functions of one call.
struct Call<'a> {
    log: Option<&'a Log<'a>>,
    progress: Option<&'a Progress<'a>>,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

impl Call<'_> {
    /// Runs a function of the host; None if it panicked.
    fn guard<T>(&self, function: impl FnOnce() -> T) -> Option<T> {
        catch_unwind(AssertUnwindSafe(function)).map_err(|panic| *self.panic.lock().unwrap() = Some(panic)).ok()
    }
}

/// SAFETY of all four: `user` is the Keeper of the host, which lives as long as what was made with it.
unsafe fn keeper<'a>(user: *mut c_void) -> &'a Keeper {
    &*user.cast::<Keeper>()
}

unsafe extern "C" fn allocate(user: *mut c_void, size: usize, alignment: usize) -> *mut c_void {
    let layout = Layout::from_size_align(size, alignment).ok();
    let memory = keeper(user).memory.as_ref();
    let block =
        layout.zip(memory).and_then(|(layout, memory)| catch_unwind(AssertUnwindSafe(|| memory.allocate(layout))).ok());
    block.unwrap_or(ptr::null_mut()).cast()
}

unsafe extern "C" fn free(user: *mut c_void, block: *mut c_void, size: usize, alignment: usize) {
    let layout = Layout::from_size_align_unchecked(size, alignment);
    if let Some(memory) = keeper(user).memory.as_ref() {
        let _ = catch_unwind(AssertUnwindSafe(|| memory.free(block.cast(), layout)));
    }
}

unsafe extern "C" fn log(user: *mut c_void, level: i32, message: *const c_char) {
    let Some(call) = keeper(user).call.load(Ordering::Acquire).as_ref() else { return };
    let level = match level {
        ffi::MLRT_LOG_ERROR => Level::Error,
        ffi::MLRT_LOG_WARNING => Level::Warning,
        _ => Level::Info,
    };
    let message = CStr::from_ptr(message).to_string_lossy();
    call.guard(|| call.log.map(|log| log(level, &message)));
}

unsafe extern "C" fn progress(user: *mut c_void, fraction: f64) -> i32 {
    let Some(call) = keeper(user).call.load(Ordering::Acquire).as_ref() else { return 0 };
    match call.guard(|| call.progress.map_or(ControlFlow::Continue(()), |progress| progress(fraction))) {
        Some(ControlFlow::Continue(())) => 0,
        _ => 1,
    }
}

/// What is left of a call with a host: to be kept by what the call made.
pub(crate) struct Kept {
    keeper: Option<Box<Keeper>>,
    panic: Option<Box<dyn Any + Send>>,
}

impl Kept {
    /// The keeper, and the panic of one of the host's functions.
    pub(crate) fn into_parts(self) -> (Option<Box<Keeper>>, Option<Box<dyn Any + Send>>) {
        (self.keeper, self.panic)
    }

    /// The keeper; goes on with a panic of one of the host's functions.
    pub(crate) fn resume(self) -> Option<Box<Keeper>> {
        if let Some(panic) = self.panic {
            resume_unwind(panic);
        }
        self.keeper
    }
}

impl Host<'_> {
    /// Calls `function` with this as an mlrt_host: NULL if there is nothing in it.
    pub(crate) fn with<T>(&self, function: impl FnOnce(*const ffi::mlrt_host) -> T) -> (T, Kept) {
        if self.memory.is_none() && self.log.is_none() && self.progress.is_none() {
            return (function(ptr::null()), Kept { keeper: None, panic: None });
        }
        let mut call = Call { log: self.log, progress: self.progress, panic: Mutex::new(None) };
        let pointer = ptr::addr_of_mut!(call).cast();
        let keeper = Box::new(Keeper { memory: self.memory.clone(), call: AtomicPtr::new(pointer) });
        let host = ffi::mlrt_host {
            user: ptr::addr_of!(*keeper).cast_mut().cast(),
            allocate: self.memory.as_ref().map(|_| allocate as ffi::mlrt_allocate_callback),
            free: self.memory.as_ref().map(|_| free as ffi::mlrt_free_callback),
            log: self.log.map(|_| log as ffi::mlrt_log_callback),
            progress: self.progress.map(|_| progress as ffi::mlrt_progress_callback),
            ..Default::default()
        };
        let result = function(&host);
        keeper.call.store(ptr::null_mut(), Ordering::Release);
        let panic = call.panic.into_inner().unwrap();
        (result, Kept { keeper: Some(keeper), panic })
    }
}
