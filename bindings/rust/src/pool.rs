// SPDX-License-Identifier: MIT
//! Threads that calls share their work with.

use std::ffi::c_void;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::ptr::{self, NonNull};
use std::sync::{Arc, Condvar, Mutex};

use crate::error::{check, Result};
use crate::ffi;
use crate::host::{Host, Keeper, Memory};

/// A piece of work for an [executor](PoolOptions::executor), to be run once, on any thread.
///
/// One that is dropped, or starts late, is run by the call that it belongs to.
pub struct Job(Arc<Task>);

#[derive(Clone, Copy, PartialEq)]
enum State {
    Waiting,
    Running,
    Done,
}

struct Task {
    state: Mutex<State>,
    done: Condvar,
    function: ffi::mlrt_task_function,
    argument: *mut c_void,
}

// SAFETY: the library lets any thread run a task.
unsafe impl Send for Task {}
unsafe impl Sync for Task {}

impl Task {
    /// Runs the task, unless another thread did or does.
    fn run(&self) {
        {
            let mut state = self.state.lock().unwrap();
            if *state != State::Waiting {
                return;
            }
            *state = State::Running;
        }
        // SAFETY: the argument is valid until `finish` has returned, which waits for `Done`.
        unsafe { (self.function)(self.argument) };
        *self.state.lock().unwrap() = State::Done;
        self.done.notify_all();
    }

    fn wait(&self) {
        let mut state = self.state.lock().unwrap();
        while *state != State::Done {
            state = self.done.wait(state).unwrap();
        }
    }
}

impl Job {
    /// Does the work. Does nothing if it is done already, or the call that it belongs to has ended.
    pub fn run(self) {
        self.0.run();
    }
}

/// Hands jobs to the threads of the program.
pub type Executor = dyn Fn(Job) + Send + Sync;

unsafe extern "C" fn enqueue(
    user: *mut c_void,
    function: ffi::mlrt_task_function,
    argument: *mut c_void,
) -> *mut c_void {
    let executor = &*user.cast::<Box<Executor>>();
    let task = Arc::new(Task { state: Mutex::new(State::Waiting), done: Condvar::new(), function, argument });
    let job = Job(task.clone());
    let _ = catch_unwind(AssertUnwindSafe(|| executor(job))); // `finish` runs a job that got lost
    Arc::into_raw(task).cast_mut().cast()
}

/// A task that has not begun is run here: so calls within jobs never wait for a thread that waits for them.
unsafe extern "C" fn finish(_user: *mut c_void, task: *mut c_void) {
    let task = Arc::from_raw(task.cast_const().cast::<Task>());
    task.run();
    task.wait();
}

/// How to make a [`Pool`].
#[derive(Default)]
pub struct PoolOptions {
    /// Threads at work, the calling one included, 1 to 1024; 0: one per processor. With `executor`: most jobs at once.
    pub thread_count: u32,
    /// Memory for the pool; `None`: malloc.
    pub memory: Option<Arc<dyn Memory>>,
    /// Runs jobs on threads of the program, so that the pool starts none: `|job| rayon::spawn(|| job.run())`.
    pub executor: Option<Box<Executor>>,
}

/// Threads that calls share their work with: its own, or those of the program.
///
/// Calls that share a pool with threads of its own wait for each other; calls that share one with an
/// [executor](PoolOptions::executor) run at once, and may be made from within a job.
pub struct Pool {
    handle: NonNull<ffi::mlrt_pool>,
    // Used by `handle`, and freed after it:
    _executor: Option<Box<Box<Executor>>>,
    _keeper: Option<Box<Keeper>>,
}

// SAFETY: mlrt.h, "Threads".
unsafe impl Send for Pool {}
unsafe impl Sync for Pool {}

impl Pool {
    /// A pool of `threads` threads, of which the calling one is one; 0: one per processor.
    pub fn new(threads: u32) -> Result<Pool> {
        let mut pool = ptr::null_mut();
        check(unsafe { ffi::mlrt_create_pool(threads, &mut pool) })?;
        Ok(Pool { handle: NonNull::new(pool).expect("a pool"), _executor: None, _keeper: None })
    }

    /// A pool that starts no threads: `executor` runs at most `jobs` - 1 at a time, and the calling thread works too.
    ///
    /// ```
    /// let pool = mlrt::Pool::with_executor(4, |job| drop(std::thread::spawn(|| job.run())))?;
    /// # Ok::<(), mlrt::Error>(())
    /// ```
    pub fn with_executor(jobs: u32, executor: impl Fn(Job) + Send + Sync + 'static) -> Result<Pool> {
        let executor: Option<Box<Executor>> = Some(Box::new(executor));
        Pool::with_options(PoolOptions { thread_count: jobs, executor, ..Default::default() })
    }

    /// A pool with options.
    pub fn with_options(options: PoolOptions) -> Result<Pool> {
        let mut pool = ptr::null_mut();
        let executor = options.executor.map(Box::new);
        let host = Host { memory: options.memory, ..Default::default() };
        let (result, kept) = host.with(|host| {
            let user = executor.as_ref().map_or(ptr::null(), |executor| ptr::addr_of!(**executor));
            let options = ffi::mlrt_pool_options {
                thread_count: options.thread_count,
                host,
                user: user.cast_mut().cast(),
                enqueue: executor.as_ref().map(|_| enqueue as ffi::mlrt_enqueue_callback),
                finish: executor.as_ref().map(|_| finish as ffi::mlrt_finish_callback),
                ..Default::default()
            };
            check(unsafe { ffi::mlrt_create_pool_with_options(&options, &mut pool) })
        });
        let keeper = kept.resume();
        result?;
        Ok(Pool { handle: NonNull::new(pool).expect("a pool"), _executor: executor, _keeper: keeper })
    }

    /// How many threads are at work, the calling one included; with an [executor](PoolOptions::executor): most jobs at
    /// once.
    pub fn thread_count(&self) -> u32 {
        // SAFETY: the handle is that of a pool.
        unsafe { ffi::mlrt_pool_thread_count(self.handle.as_ptr()) }
    }

    /// The handle of the C interface.
    pub fn as_ptr(&self) -> *mut ffi::mlrt_pool {
        self.handle.as_ptr()
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        // SAFETY: borrows of this pool have ended, and so have the calls that used it.
        unsafe { ffi::mlrt_destroy_pool(self.handle.as_ptr()) }
    }
}

impl std::fmt::Debug for Pool {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(if self._executor.is_some() { "Pool(executor)" } else { "Pool" })
    }
}
