/* SPDX-License-Identifier: MIT */
/*
 * mlrt.hpp - mlrt.h for C++11 and later: objects that free themselves, errors as exceptions or results, arrays of any
 * container. Header only; link libmlrt, and threads if a Pool has an executor.
 *
 *     const mlrt::Tree tree({mlrt::mesh(vertices, triangles)});
 *     const mlrt::Hits hits = tree.trace(mlrt::Rays(origins, directions));
 *
 * Options, cameras, lights and single rays are the structs of mlrt.h, whose text says what each field means; the types
 * here (TraceOptions and so on) only set the size and zeros, which are the defaults; Camera also sets the sample to the
 * middle of the pixel. Objects can be moved, not copied. One that was moved from is empty: calls of an empty tree fail,
 * and an empty pool stands for the calling thread alone.
 *
 * Every function of mlrt.h comes twice. `trace` throws an Error; `try_trace` returns a Status, or a Result with a value, and is there
 * with -fno-exceptions, too. Both can throw std::bad_alloc where they return vectors.
 *
 * An exception that leaves a callback is thrown again when the call ends. One of `progress` or of a callback of tiles ends
 * the call, one of `allocate` makes it fail, one of `log` does neither. `free` must not throw.
 */
#ifndef MLRT_HPP
#define MLRT_HPP

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mlrt.h"

#if defined(__cpp_exceptions) || defined(__EXCEPTIONS) || defined(_CPPUNWIND)
#define MLRT_EXCEPTIONS 1
#else
#define MLRT_EXCEPTIONS 0
#endif

namespace mlrt {

/* ------------------------------------------------------------------------------------------------------------------
 * Errors
 * ------------------------------------------------------------------------------------------------------------------ */

#if MLRT_EXCEPTIONS
/* what() is the text for the status, and which argument, value and rule it is about. */
struct Error : std::runtime_error {
    int32_t status; /* MLRT_ERROR_* */
    Error(int32_t code, const std::string &text) : std::runtime_error(text), status(code) {}
};
#endif

/* How a call ended. True in a condition if it succeeded. */
class Status {
    int32_t code_ = MLRT_OK;
    std::string message_;
    std::exception_ptr thrown_;

  public:
    Status() = default;
    Status(int32_t code, std::string message) : code_(code), message_(std::move(message)) {}

    /* The end of a call of the C interface that has just returned `code` to this thread. */
    static Status of(int32_t code) { return code == MLRT_OK ? Status() : Status(code, mlrt_last_message()); }

    explicit operator bool() const { return code_ == MLRT_OK; }
    int32_t code() const { return code_; }                  /* MLRT_OK or MLRT_ERROR_* */
    const std::string &message() const { return message_; } /* which argument, which value, which rule */
    std::exception_ptr thrown() const { return thrown_; }   /* what left a callback, or NULL */
    void set_thrown(std::exception_ptr thrown) { thrown_ = std::move(thrown); }

    /* The meaning of the code, and the message. */
    std::string text() const {
        const std::string meaning = mlrt_status_string(code_);
        return message_.empty() || message_ == meaning ? meaning : meaning + ": " + message_;
    }

#if MLRT_EXCEPTIONS
    /* Throws what left a callback, or an Error, unless the call succeeded. */
    void check() const {
        if (thrown_) std::rethrow_exception(thrown_);
        if (code_ != MLRT_OK) throw Error(code_, text());
    }
#endif
};

/* A status, and the value if the call succeeded. */
template <class T> struct Result : Status {
    T value = T();
    Result() = default;
    Result(Status status) : Status(std::move(status)) {}

#if MLRT_EXCEPTIONS
    /* The value; throws if there is none. */
    T take() {
        this->check();
        return std::move(value);
    }
#endif
};

/* ------------------------------------------------------------------------------------------------------------------
 * Structs of the C interface
 * ------------------------------------------------------------------------------------------------------------------ */

/* A struct of the C interface: its size is set, all other fields are 0, so defaults. */
template <class Struct> Struct make() {
    Struct s = Struct();
    s.struct_size = sizeof s;
    return s;
}

struct TreeOptions : mlrt_tree_options {
    TreeOptions() : mlrt_tree_options(make<mlrt_tree_options>()) {}
};
struct KdTreeOptions : mlrt_kdtree_options {
    KdTreeOptions() : mlrt_kdtree_options(make<mlrt_kdtree_options>()) {}
};
struct LoadOptions : mlrt_load_options {
    LoadOptions() : mlrt_load_options(make<mlrt_load_options>()) {}
};
struct Counters : mlrt_counters {
    Counters() : mlrt_counters(make<mlrt_counters>()) {}
};

/* The size in bytes of elements and arrays, which the compiler knows. */
namespace detail {

template <class C> using Element = typename std::remove_pointer<decltype(std::declval<C &>().data())>::type;

/* The type of the numbers that E is or has, as far as it tells (by its value_type, for example); else void. */
template <class E, bool is_enum = std::is_enum<E>::value> struct Number : std::underlying_type<E> {};
template <class E>
struct Number<E, false> : std::conditional<std::is_class<E>::value || std::is_union<E>::value, void, E> {};
template <class T> struct Always { typedef void type; };
template <class E, class = void> struct Numbers : Number<E> {};
template <class E>
struct Numbers<E, typename Always<typename E::value_type>::type>
    : Numbers<typename std::remove_cv<typename E::value_type>::type> {};
template <class E, size_t N> struct Numbers<E[N], void> : Numbers<typename std::remove_cv<E>::type> {};

/* Are the bits of a T those of an S? Integers may differ in their sign. */
template <class T, class S>
struct IsNumber : std::integral_constant<bool, std::is_arithmetic<T>::value && sizeof(T) == sizeof(S) &&
                                                   std::is_integral<T>::value == std::is_integral<S>::value> {};
template <class S> struct IsNumber<void, S> : std::true_type {};

/* Has E the size of N numbers S, and if it tells the type of its numbers, is it S? */
template <class E, class S, size_t N>
struct IsElement
    : std::integral_constant<bool, sizeof(E) == N * sizeof(S) &&
                                       IsNumber<typename Numbers<typename std::remove_cv<E>::type>::type, S>::value> {};

/* Can a container of E be one of numbers S, or of elements of N of them? */
template <class E, class S, size_t N>
struct Fits : std::integral_constant<bool, std::is_same<typename std::remove_cv<E>::type, S>::value ||
                                               (!std::is_arithmetic<E>::value && std::is_trivially_copyable<E>::value &&
                                                IsElement<E, S, N>::value && alignof(E) % alignof(S) == 0)> {};

/* a * b, or the greatest number if it is beyond it. */
inline size_t product(size_t a, size_t b) {
    const size_t most = std::numeric_limits<size_t>::max();
    return b != 0 && a > most / b ? most : a * b;
}

/* Rays and points are counted in 31 bits: asked before memory is taken for their results. */
inline Status check_count(const char *name, size_t count) {
    if (count <= static_cast<size_t>(std::numeric_limits<int32_t>::max())) return Status();
    return Status(MLRT_ERROR_TOO_LARGE, std::string(name) + ": " + std::to_string(count) + " is more than 2147483647");
}

} // namespace detail

/* ------------------------------------------------------------------------------------------------------------------
 * Arrays
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * Elements of N numbers S that the library reads where they lie: a container with data() and size(), of numbers or of
 * structs of N numbers (std::array<float, 3>, glm::vec3); a field of structs; or one element that serves all rays. A
 * struct with a `value_type` must have the right one; of others only the size is looked at. An empty Input is left out.
 * It refers to the container, which must live until the call returns.
 */
template <class S, size_t N = 1> class Input {
    const void *data_ = nullptr;
    size_t count_ = 0;
    size_t stride_ = 0;

  public:
    Input() = default;

    /* `count` elements, `stride` bytes apart; 0 = packed. */
    Input(const S *data, size_t count, size_t stride = 0) : data_(data), count_(count), stride_(stride) {}

    template <class C, class E = detail::Element<const C>,
              class = typename std::enable_if<detail::Fits<E, S, N>::value>::type>
    Input(const C &container)
        : data_(container.size() ? container.data() : nullptr), count_(container.size() * sizeof(E) / (N * sizeof(S))),
          stride_(0) {}

    /* One element, of one number or a struct of N of them, that serves all rays; it must live until the call returns. */
    template <class E> static Input all(const E &element) {
        static_assert(detail::IsElement<E, S, N>::value, "an element of another type or size");
        return Input(reinterpret_cast<const S *>(&element), 1, MLRT_STRIDE_ALL);
    }
    template <class E> static Input all(const E &&) = delete;

    /* A field of all structs: Input<float, 3>::field(vertices, &Vertex::position). */
    template <class C, class Struct, class Field> static Input field(const C &structs, Field Struct::*member) {
        static_assert(detail::IsElement<Field, S, N>::value, "a field of another type or size");
        const void *first = structs.size() ? &(structs.data()->*member) : nullptr;
        return Input(static_cast<const S *>(first), structs.size(), sizeof(detail::Element<const C>));
    }

    const void *address() const { return data_; }
    size_t count() const { return count_; }
    size_t stride() const { return stride_; }
    bool serves_all() const { return stride_ == MLRT_STRIDE_ALL; }
};

/* Numbers S, or elements of N of them, that the library writes: a container, or a field of structs. Empty: left out. */
template <class S, size_t N = 1> class Output {
    void *data_ = nullptr;
    size_t size_ = 0; /* bytes from data_ on */
    size_t stride_ = N * sizeof(S);
    size_t row_stride_ = 0;

    /* Rows may lie within each other, as those of a transposed picture do. There must be space for all. */
    bool rows_overlap(size_t columns, size_t row_count) const {
        for (size_t row = 1; row < row_count && row * row_stride_ / stride_ < columns; row++) {
            const size_t column = row * row_stride_ / stride_, rest = row * row_stride_ % stride_;
            if (rest < N * sizeof(S) || (column + 1 < columns && stride_ - rest < N * sizeof(S))) return true;
        }
        return false;
    }

  public:
    Output() = default;

    /* `size` bytes from `data` on: elements `stride` bytes apart, and rows of pixels `row_stride` bytes; 0 = packed. */
    Output(S *data, size_t size, size_t stride = 0, size_t row_stride = 0)
        : data_(data), size_(size), stride_(stride ? stride : N * sizeof(S)), row_stride_(row_stride) {}

    template <class C, class E = detail::Element<C>,
              class = typename std::enable_if<!std::is_const<E>::value && detail::Fits<E, S, N>::value>::type>
    Output(C &container) : data_(container.size() ? container.data() : nullptr), size_(container.size() * sizeof(E)) {}

    /* A field of all structs: Output<float>::field(pixels, &Pixel::depth). */
    template <class C, class Struct, class Field> static Output field(C &structs, Field Struct::*member) {
        static_assert(detail::IsElement<Field, S, N>::value, "a field of another type or size");
        if (!structs.size()) return Output();
        const size_t stride = sizeof(detail::Element<C>);
        char *const first = reinterpret_cast<char *>(&(structs.data()->*member));
        const size_t offset = static_cast<size_t>(first - reinterpret_cast<char *>(structs.data()));
        return Output(reinterpret_cast<S *>(first), structs.size() * stride - offset, stride);
    }

    /* The same for pictures whose rows begin every `bytes` bytes. */
    Output rows(size_t bytes) const {
        Output copy = *this;
        copy.row_stride_ = bytes;
        return copy;
    }

    /* Is there space for so many elements, in rows that do not overlap? One that is left out has space for all. */
    bool fits(size_t columns, size_t row_count) const {
        if (!data_ || !columns || !row_count) return true;
        size_t left = size_; /* divided, as products may be beyond size_t */
        const auto take = [&left](size_t count, size_t bytes) {
            return count == 0 || (bytes <= left / count && (left -= count * bytes, true));
        };
        if (!take(1, N * sizeof(S)) || !take(columns - 1, stride_)) return false;
        if (row_count == 1) return true;
        if (!row_stride_) return take(row_count - 1, stride_) && take(row_count - 1, (columns - 1) * stride_);
        return take(row_count - 1, row_stride_) && !rows_overlap(columns, row_count);
    }

    mlrt_array array() const {
        mlrt_array a = {data_, stride_, row_stride_};
        return a;
    }
};

/* ------------------------------------------------------------------------------------------------------------------
 * Hosts and pools
 * ------------------------------------------------------------------------------------------------------------------ */

/*
 * Functions for options.host: `options.host = host.get()`. Set those that you need, before. It must live until the call
 * returns, and with `allocate` until everything that was made with it is destroyed. Several calls may use it at once;
 * an exception is thrown again by one of them, which need not be the one whose function it left.
 */
class Host {
    mutable mlrt_host c_;
    mutable std::mutex mutex_;
    mutable std::exception_ptr thrown_;

    template <class F, class T> static T guard(void *user, T otherwise, F function) {
        const Host *host = static_cast<const Host *>(user);
#if MLRT_EXCEPTIONS
        try {
            return function(*host);
        } catch (...) {
            const std::lock_guard<std::mutex> lock(host->mutex_);
            host->thrown_ = std::current_exception();
            return otherwise;
        }
#else
        (void)otherwise;
        return function(*host);
#endif
    }
    static void *call_allocate(void *user, size_t size, size_t alignment) {
        return guard(user, static_cast<void *>(nullptr), [=](const Host &h) { return h.allocate(size, alignment); });
    }
    static void call_free(void *user, void *block, size_t size, size_t alignment) {
        static_cast<const Host *>(user)->free(block, size, alignment);
    }
    static void call_log(void *user, int32_t level, const char *message) {
        guard(user, 0, [=](const Host &h) { return h.log(level, message), 0; });
    }
    static int32_t call_progress(void *user, double fraction) {
        return guard(user, 1, [=](const Host &h) { return h.progress(fraction) ? 0 : 1; });
    }

  public:
    std::function<void *(size_t size, size_t alignment)> allocate; /* both of these or neither; see mlrt_host */
    std::function<void(void *block, size_t size, size_t alignment)> free;
    std::function<void(int32_t level, const char *message)> log; /* level: MLRT_LOG_* */
    std::function<bool(double fraction)> progress;               /* false cancels the call */

    Host() : c_(make<mlrt_host>()) {}
    Host(const Host &) = delete;
    Host &operator=(const Host &) = delete;

    const mlrt_host *get() const {
        mlrt_host c = make<mlrt_host>();
        c.user = const_cast<Host *>(this);
        c.allocate = allocate ? call_allocate : nullptr;
        c.free = free ? call_free : nullptr;
        c.log = log ? call_log : nullptr;
        c.progress = progress ? call_progress : nullptr;
        const std::lock_guard<std::mutex> lock(mutex_);
        if (std::memcmp(&c, &c_, sizeof c) != 0) c_ = c; /* else calls of other threads may be reading it */
        return &c_;
    }

    /* What left a function of a host of this class during the last call. */
    static std::exception_ptr thrown_by(const mlrt_host *c) {
        if (!c || (c->log != call_log && c->progress != call_progress && c->allocate != call_allocate)) return nullptr;
        const Host *host = static_cast<const Host *>(c->user);
        const std::lock_guard<std::mutex> lock(host->mutex_);
        std::exception_ptr thrown;
        std::swap(thrown, host->thrown_);
        return thrown;
    }
};

namespace detail {

struct Destroy {
    void operator()(mlrt_tree *tree) const { mlrt_destroy_tree(tree); }
    void operator()(mlrt_pool *pool) const { mlrt_destroy_pool(pool); }
};

/* The status of a call that has just ended, with what its host's functions have thrown. */
inline Status ended(int32_t code, const mlrt_host *host) {
    Status status = Status::of(code);
    status.set_thrown(Host::thrown_by(host));
    return status;
}

/* A task of a pool with an executor: run once, by the thread that comes first. */
class Task {
    enum State { WAITING, RUNNING, DONE };
    std::mutex mutex;
    std::condition_variable done;
    State state = WAITING;
    const mlrt_task_function function;
    void *const argument;

  public:
    Task(mlrt_task_function f, void *a) : function(f), argument(a) {}
    void run() {
        {
            const std::lock_guard<std::mutex> lock(mutex);
            if (state != WAITING) return;
            state = RUNNING;
        }
        function(argument);
        const std::lock_guard<std::mutex> lock(mutex);
        state = DONE;
        done.notify_all();
    }
    void wait() {
        std::unique_lock<std::mutex> lock(mutex);
        done.wait(lock, [this] { return state == DONE; });
    }
};

} // namespace detail

/* Threads that calls share their work with: its own, or those of the program. */
class Pool {
  public:
    /* Runs a job on any thread, now or later. A job that has not begun when its call needs it does nothing any more. */
    typedef std::function<void(std::function<void()> job)> Executor;

  private:
    std::unique_ptr<Executor> executor; /* outlives the handle */
    std::unique_ptr<mlrt_pool, detail::Destroy> handle;

    static void *enqueue(void *user, mlrt_task_function function, void *argument) {
        const Executor &execute = *static_cast<const Executor *>(user);
        std::unique_ptr<std::shared_ptr<detail::Task>> kept;
#if MLRT_EXCEPTIONS
        try {
#endif
            const auto task = std::make_shared<detail::Task>(function, argument);
            kept.reset(new std::shared_ptr<detail::Task>(task));
            execute([task] { task->run(); });
#if MLRT_EXCEPTIONS
        } catch (...) {                    // finish runs a job that got lost
            if (!kept) function(argument); // no memory for one
        }
#endif
        return kept.release();
    }
    static void finish(void *, void *handle) {
        const std::unique_ptr<std::shared_ptr<detail::Task>> task(static_cast<std::shared_ptr<detail::Task> *>(handle));
        (*task)->run();
        (*task)->wait();
    }

  public:
    /* The options of mlrt_create_pool_with_options, as they are. */
    static Result<Pool> try_create(const mlrt_pool_options &options) {
        Result<Pool> result;
        mlrt_pool *pool = nullptr;
        static_cast<Status &>(result) = detail::ended(mlrt_create_pool_with_options(&options, &pool), options.host);
        result.value.handle.reset(pool);
        return result;
    }
    /* `threads` threads, of which the calling one is one; 0 = one per processor. */
    static Result<Pool> try_create(uint32_t threads = 0) {
        Result<Pool> result;
        mlrt_pool *pool = nullptr;
        static_cast<Status &>(result) = Status::of(mlrt_create_pool(threads, &pool));
        result.value.handle.reset(pool);
        return result;
    }
    /* No threads: `executor` runs `jobs` - 1 at a time at most, and the calling thread works, too. */
    static Result<Pool> try_create(uint32_t jobs, Executor executor) {
        if (!executor) return Status(MLRT_ERROR_ARGUMENT, "executor: it is empty");
        std::unique_ptr<Executor> kept(new Executor(std::move(executor)));
        mlrt_pool_options options = make<mlrt_pool_options>();
        options.thread_count = jobs, options.user = kept.get(), options.enqueue = enqueue, options.finish = finish;
        Result<Pool> result = try_create(options);
        result.value.executor = std::move(kept);
        return result;
    }

#if MLRT_EXCEPTIONS
    explicit Pool(uint32_t threads) : Pool(try_create(threads).take()) {}
    Pool(uint32_t jobs, Executor run) : Pool(try_create(jobs, std::move(run)).take()) {}
    explicit Pool(const mlrt_pool_options &options) : Pool(try_create(options).take()) {}
#endif
    /* An empty pool: the calling thread alone. */
    Pool() = default;

    mlrt_pool *get() const { return handle.get(); }
    /* How many threads are at work, the calling one included; with an executor, how many jobs. 1 of an empty pool. */
    uint32_t thread_count() const { return mlrt_pool_thread_count(handle.get()); }
};

/* ------------------------------------------------------------------------------------------------------------------
 * Meshes, rays, results
 * ------------------------------------------------------------------------------------------------------------------ */

/* A mesh, whose arrays must live until the tree is built. */
template <class Index>
mlrt_mesh mesh_of(Input<float, 3> vertices, Input<Index, 3> triangles, uint32_t id, uint32_t mask) {
    mlrt_mesh m = make<mlrt_mesh>();
    m.id = id, m.mask = mask;
    m.vertices = vertices.address(), m.vertex_count = vertices.count(), m.vertex_stride = vertices.stride();
    m.indices = triangles.address(), m.triangle_count = triangles.count(), m.triangle_stride = triangles.stride();
    m.index_size = sizeof(Index);
    return m;
}
inline mlrt_mesh mesh(Input<float, 3> vertices, Input<uint32_t, 3> triangles, uint32_t id = 0, uint32_t mask = 0) {
    return mesh_of(vertices, triangles, id, mask);
}
inline mlrt_mesh mesh(Input<float, 3> vertices, Input<uint16_t, 3> triangles, uint32_t id = 0, uint32_t mask = 0) {
    return mesh_of(vertices, triangles, id, mask);
}
/* Triangle i has the vertices 3i, 3i + 1, 3i + 2. */
inline mlrt_mesh mesh(Input<float, 3> vertices, uint32_t id = 0, uint32_t mask = 0) {
    mlrt_mesh m = mesh_of(vertices, Input<uint32_t, 3>(), id, mask);
    m.triangle_count = vertices.count() / 3;
    return m;
}

/* Rays. Each array has an element per ray, or one that serves all; an empty one is left out. See mlrt_rays. */
struct Rays {
    Input<float, 3> origins, directions;
    Input<float> t_min, t_max;
    Input<uint32_t, 2> skip;
    Input<uint32_t> mask;
    uint32_t row_length = 0;
    uint32_t rays_per_origin = 0;

    Rays() = default;
    Rays(Input<float, 3> from, Input<float, 3> along) : origins(from), directions(along) {}

    /* How many there are: as many as directions, or as origins if one direction serves all. */
    size_t count() const {
        return directions.serves_all() ? detail::product(origins.count(), rays_per_origin ? rays_per_origin : 1)
                                       : directions.count();
    }
};

/* A ray for trace_ray. */
struct Ray : mlrt_ray {
    Ray() : mlrt_ray(make<mlrt_ray>()) {}
    Ray(const std::array<float, 3> &from, const std::array<float, 3> &along) : mlrt_ray(make<mlrt_ray>()) {
        for (size_t k = 0; k < 3; k++) origin[k] = from[k], direction[k] = along[k];
    }
    Ray &pass_through(uint32_t mesh, uint32_t triangle) {
        flags |= MLRT_RAY_SKIP, skip_mesh = mesh, skip_triangle = triangle;
        return *this;
    }
};

/* The hit of one ray, as a struct and in arrays of structs (HitArrays::records). A miss has mesh = MLRT_NONE. */
struct Hit {
    float t, u, v;
    uint32_t mesh, triangle;
    int32_t facing;
    explicit operator bool() const { return facing != 0; }
};

/* Arrays that receive results. Those that are left out are not computed. See mlrt_hits. */
struct HitArrays {
    Output<float> t, u, v;
    Output<uint32_t> mesh, triangle;
    Output<int32_t> facing;
    Output<uint8_t> occluded;

    template <class C> static HitArrays records(C &hits) {
        HitArrays a;
        a.t = Output<float>::field(hits, &Hit::t), a.u = Output<float>::field(hits, &Hit::u);
        a.v = Output<float>::field(hits, &Hit::v), a.mesh = Output<uint32_t>::field(hits, &Hit::mesh);
        a.triangle = Output<uint32_t>::field(hits, &Hit::triangle),
        a.facing = Output<int32_t>::field(hits, &Hit::facing);
        return a;
    }
    bool fits(size_t columns, size_t rows) const {
        return t.fits(columns, rows) && u.fits(columns, rows) && v.fits(columns, rows) && mesh.fits(columns, rows) &&
               triangle.fits(columns, rows) && facing.fits(columns, rows) && occluded.fits(columns, rows);
    }
    mlrt_hits c() const {
        mlrt_hits h = make<mlrt_hits>();
        h.t = t.array(), h.u = u.array(), h.v = v.array(), h.mesh = mesh.array(), h.triangle = triangle.array();
        h.facing = facing.array(), h.occluded = occluded.array();
        return h;
    }
};

/* Closest hits, one element per ray or pixel; a miss has t = inf and mesh = triangle = MLRT_NONE. */
struct Hits {
    std::vector<float> t, u, v;
    std::vector<uint32_t> mesh, triangle;
    std::vector<int32_t> facing;

    explicit Hits(size_t n = 0) : t(n), u(n), v(n), mesh(n), triangle(n), facing(n) {}
    size_t size() const { return facing.size(); }
    HitArrays arrays() {
        HitArrays a;
        a.t = t, a.u = u, a.v = v, a.mesh = mesh, a.triangle = triangle, a.facing = facing;
        return a;
    }
};

/* Arrays that receive lists of hits. See mlrt_hit_lists. */
struct HitListArrays {
    uint32_t capacity = 0;
    Output<float> t, u, v;
    Output<uint32_t> mesh, triangle;
    Output<int32_t> facing;
    Output<uint8_t> crossing;
    Output<uint32_t> total, crossing_total;
};

/* All hits of rays: hit j of ray i is element i * capacity + j. */
struct HitLists {
    uint32_t capacity;
    std::vector<float> t, u, v;
    std::vector<uint32_t> mesh, triangle;
    std::vector<int32_t> facing;
    std::vector<uint8_t> crossing;
    std::vector<uint32_t> total, crossing_total;

    explicit HitLists(size_t rays = 0, uint32_t per_ray = 0)
        : capacity(per_ray), t(detail::product(rays, per_ray)), u(t.size()), v(t.size()), mesh(t.size()),
          triangle(t.size()), facing(t.size()), crossing(t.size()), total(rays), crossing_total(rays) {}
    HitListArrays arrays() {
        HitListArrays a;
        a.capacity = capacity;
        a.t = t, a.u = u, a.v = v, a.mesh = mesh, a.triangle = triangle, a.facing = facing, a.crossing = crossing;
        a.total = total, a.crossing_total = crossing_total;
        return a;
    }
};

struct Light : mlrt_light {
    Light(int32_t of_kind, const std::array<float, 3> &at) : mlrt_light(make<mlrt_light>()) {
        kind = of_kind;
        for (size_t k = 0; k < 3; k++) position[k] = at[k];
    }
    static Light point(const std::array<float, 3> &position) { return Light(MLRT_LIGHT_POINT, position); }
    static Light directional(const std::array<float, 3> &towards) { return Light(MLRT_LIGHT_DIRECTIONAL, towards); }
};

/* How to trace. `set` takes objects of this header, which must live until the call returns. */
struct TraceOptions : mlrt_trace_options {
    TraceOptions() : mlrt_trace_options(make<mlrt_trace_options>()) {}
    TraceOptions &set(const Pool &with) { return pool = with.get(), *this; }
    TraceOptions &set(const Host &with) { return host = with.get(), *this; }
    TraceOptions &set(Counters &with) { return counters = &with, *this; }
    TraceOptions &set(const std::vector<Light> &with) {
        static_assert(sizeof(Light) == sizeof(mlrt_light), "lights are an array of the C interface");
        lights = with.empty() ? nullptr : with.data(), light_count = static_cast<uint32_t>(with.size());
        return *this;
    }
};

/* A camera. See mlrt_camera. */
struct Camera : mlrt_camera {
    Camera() : mlrt_camera(make<mlrt_camera>()) { sample_x = sample_y = 0.5f; }
    size_t columns() const { return crop_width ? crop_width : width > crop_x ? width - crop_x : 0; }
    size_t rows() const { return crop_height ? crop_height : height > crop_y ? height - crop_y : 0; }

    /* The very rays that render traces, row by row. */
    Status try_rays(Output<float, 3> origins, Output<float, 3> directions) const {
        if (!origins.fits(columns(), rows()) || !directions.fits(columns(), rows()))
            return Status(MLRT_ERROR_ARGUMENT, "an array is shorter than the rays of the camera, or its rows overlap");
        const mlrt_array from = origins.array(), along = directions.array();
        return Status::of(mlrt_camera_rays(this, &from, &along));
    }
#if MLRT_EXCEPTIONS
    void rays(Output<float, 3> origins, Output<float, 3> directions) const { try_rays(origins, directions).check(); }
#endif
};

/* Points that may lie in the shadow of a light. See mlrt_points. */
struct Points {
    Input<float, 3> positions;
    Input<uint32_t, 2> skip;
    uint32_t row_length = 0;
    explicit Points(Input<float, 3> at) : positions(at) {}
};

/* Receives the tiles of a picture, from the threads of the pool; false ends the render. */
typedef std::function<bool(const mlrt_tile &)> TileCallback;

/* The library's version: major * 10000 + minor * 100 + patch. */
inline uint32_t version() { return mlrt_version(); }

/* What the library can do on this machine: MLRT_CAN_*. */
inline uint64_t capabilities() { return mlrt_capabilities(); }

/* Is the library as new as this header, so that it knows all fields of its structs? */
inline bool knows_all_structs() {
    uint32_t sizes[MLRT_STRUCT_COUNT];
    mlrt_struct_sizes(sizes, MLRT_STRUCT_COUNT);
    return sizes[MLRT_STRUCT_TRACE_OPTIONS] >= sizeof(mlrt_trace_options) && sizes[MLRT_STRUCT_COUNT - 1] != 0;
}

/* ------------------------------------------------------------------------------------------------------------------
 * Trees
 * ------------------------------------------------------------------------------------------------------------------ */

namespace detail {

/* Checks the lengths of inputs, and keeps the first complaint. */
class Lengths {
    Status status;

  public:
    template <class S, size_t N> mlrt_const_array operator()(const char *name, Input<S, N> input, size_t count) {
        if (input.address() && !input.serves_all() && input.count() != count && status)
            status = Status(MLRT_ERROR_ARGUMENT, std::string(name) + ": " + std::to_string(input.count()) +
                                                     " elements, where " + std::to_string(count) + " are needed");
        mlrt_const_array array = {input.address(), input.stride()};
        return array;
    }
    const Status &result() const { return status; }
};

inline Status convert(const Rays &from, mlrt_rays &to) {
    const size_t count = from.count(), shared = from.rays_per_origin ? from.rays_per_origin : 1;
    if (count % shared)
        return Status(MLRT_ERROR_ARGUMENT, "rays.rays_per_origin: it does not divide the number of rays");
    Lengths lengths;
    to = make<mlrt_rays>();
    to.count = count, to.row_length = from.row_length, to.rays_per_origin = from.rays_per_origin;
    to.origins = lengths("rays.origins", from.origins, count / shared);
    to.directions = lengths("rays.directions", from.directions, count);
    to.t_min = lengths("rays.t_min", from.t_min, count / shared);
    to.t_max = lengths("rays.t_max", from.t_max, count);
    to.skip = lengths("rays.skip", from.skip, count / shared);
    to.mask = lengths("rays.mask", from.mask, count);
    return lengths.result();
}

inline Status too_short() {
    return Status(MLRT_ERROR_ARGUMENT, "an array of results is shorter than the results, or its rows overlap");
}

} // namespace detail

/* Estimates of the memory of the builders: from the numbers of triangles alone. */
inline Result<mlrt_memory_estimate> try_estimate(const std::vector<mlrt_mesh> &meshes, const TreeOptions &options) {
    Result<mlrt_memory_estimate> result;
    result.value = make<mlrt_memory_estimate>();
    static_cast<Status &>(result) =
        Status::of(mlrt_estimate_tree(meshes.data(), meshes.size(), &options, &result.value));
    return result;
}
inline Result<mlrt_memory_estimate> try_estimate(const std::vector<mlrt_mesh> &meshes, const KdTreeOptions &options) {
    Result<mlrt_memory_estimate> result;
    result.value = make<mlrt_memory_estimate>();
    static_cast<Status &>(result) =
        Status::of(mlrt_estimate_kdtree(meshes.data(), meshes.size(), &options, &result.value));
    return result;
}

/* A hash of the ids, masks and corners of meshes, for LoadOptions::geometry_hash. */
inline Result<uint64_t> try_hash_geometry(const std::vector<mlrt_mesh> &meshes) {
    Result<uint64_t> result;
    static_cast<Status &>(result) = Status::of(mlrt_hash_geometry(meshes.data(), meshes.size(), &result.value));
    return result;
}

/* Triangles, and the structure that finds them. It never changes, and any number of threads may trace it at once. */
class Tree {
    std::unique_ptr<mlrt_tree, detail::Destroy> handle;

    static Result<Tree> made(int32_t code, const mlrt_host *host, mlrt_tree *tree) {
        Result<Tree> result(detail::ended(code, host));
        result.value.handle.reset(tree);
        return result;
    }

    static int32_t receive(void *user, const mlrt_tile *tile) {
        Render &render = *static_cast<Render *>(user);
#if MLRT_EXCEPTIONS
        try {
            return (*render.callback)(*tile) ? 0 : 1;
        } catch (...) {
            const std::lock_guard<std::mutex> lock(render.mutex);
            render.thrown = std::current_exception();
            return 1;
        }
#else
        return (*render.callback)(*tile) ? 0 : 1;
#endif
    }

    struct Render {
        const TileCallback *callback;
        std::mutex mutex;
        std::exception_ptr thrown;
    };

  public:
    /* An empty tree, whose calls fail. */
    Tree() = default;

    mlrt_tree *get() const { return handle.get(); }

    /* Builds a hierarchy of boxes: mlrt_build_tree. */
    static Result<Tree> try_build(const std::vector<mlrt_mesh> &meshes, const TreeOptions &options = TreeOptions()) {
        mlrt_tree *tree = nullptr;
        const int32_t code = mlrt_build_tree(meshes.data(), meshes.size(), &options, &tree);
        return made(code, options.host, tree);
    }
    /* Builds the paper's kd-tree: mlrt_build_kdtree. */
    static Result<Tree> try_build(const std::vector<mlrt_mesh> &meshes, const KdTreeOptions &options) {
        mlrt_tree *tree = nullptr;
        const int32_t code = mlrt_build_kdtree(meshes.data(), meshes.size(), &options, &tree);
        return made(code, options.host, tree);
    }
    /* Loads a saved tree. With MLRT_LOAD_IN_PLACE in options.flags the bytes must outlive the tree. */
    static Result<Tree> try_load(const void *data, size_t size, const LoadOptions &options = LoadOptions()) {
        mlrt_tree *tree = nullptr;
        const int32_t code = mlrt_load_tree(data, size, &options, &tree);
        return made(code, options.host, tree);
    }

    Result<mlrt_tree_info> try_info() const {
        Result<mlrt_tree_info> result;
        result.value = make<mlrt_tree_info>();
        static_cast<Status &>(result) = Status::of(mlrt_get_tree_info(get(), &result.value));
        return result;
    }

    /* The tree as bytes, with its triangles. */
    Result<std::vector<uint8_t>> try_save() const {
        Result<std::vector<uint8_t>> result;
        size_t size = 0;
        Status status = Status::of(mlrt_save_tree(get(), nullptr, 0, &size));
        if (status) {
            result.value.resize(size);
            status = Status::of(mlrt_save_tree(get(), result.value.data(), size, &size));
        }
        static_cast<Status &>(result) = status;
        return result;
    }

    /* Writes the answers of options.query to arrays: mlrt_trace_packet. */
    Status try_trace(const Rays &rays, const HitArrays &hits, const TraceOptions &options = TraceOptions()) const {
        mlrt_rays from;
        const Status status = detail::convert(rays, from);
        if (!status) return status;
        if (!hits.fits(from.count, 1)) return detail::too_short();
        const mlrt_hits to = hits.c();
        return detail::ended(mlrt_trace_packet(get(), &from, &options, &to), options.host);
    }

    /* The closest hit of one ray. */
    Result<Hit> try_trace_ray(const Ray &ray, TraceOptions options = TraceOptions()) const {
        mlrt_hit h = make<mlrt_hit>();
        options.query = MLRT_QUERY_CLOSEST;
        Result<Hit> result(Status::of(mlrt_trace_ray(get(), &ray, &options, &h)));
        result.value.t = h.t, result.value.u = h.u, result.value.v = h.v;
        result.value.mesh = h.mesh, result.value.triangle = h.triangle, result.value.facing = h.facing;
        return result;
    }

    /* Does one ray hit anything? */
    Result<bool> try_occluded_ray(const Ray &ray, TraceOptions options = TraceOptions()) const {
        mlrt_hit h = make<mlrt_hit>();
        options.query = MLRT_QUERY_ANY;
        Result<bool> result(Status::of(mlrt_trace_ray(get(), &ray, &options, &h)));
        result.value = h.occluded != 0;
        return result;
    }

    /* Writes all hits of each ray to arrays: mlrt_trace_all_hits. */
    Status try_all_hits(const Rays &rays, const HitListArrays &lists,
                        const TraceOptions &options = TraceOptions()) const {
        mlrt_rays from;
        const Status status = detail::convert(rays, from);
        if (!status) return status;
        const size_t n = detail::product(from.count, lists.capacity);
        if (!lists.t.fits(n, 1) || !lists.u.fits(n, 1) || !lists.v.fits(n, 1) || !lists.mesh.fits(n, 1) ||
            !lists.triangle.fits(n, 1) || !lists.facing.fits(n, 1) || !lists.crossing.fits(n, 1) ||
            !lists.total.fits(from.count, 1) || !lists.crossing_total.fits(from.count, 1))
            return detail::too_short();
        mlrt_hit_lists to = make<mlrt_hit_lists>();
        to.capacity = lists.capacity;
        if (lists.capacity) {
            to.t = lists.t.array(), to.u = lists.u.array(), to.v = lists.v.array(), to.mesh = lists.mesh.array();
            to.triangle = lists.triangle.array(), to.facing = lists.facing.array(),
            to.crossing = lists.crossing.array();
        }
        to.total = lists.total.array(), to.crossing_total = lists.crossing_total.array();
        return detail::ended(mlrt_trace_all_hits(get(), &from, &options, &to), options.host);
    }

    /* Renders a picture into arrays (NULL: none), or to a callback (empty: none), or both: mlrt_render_tiles. */
    Status try_render(const Camera &camera, const HitArrays *frame, const TileCallback &callback,
                      const TraceOptions &options = TraceOptions()) const {
        if (frame && !frame->fits(camera.columns(), camera.rows())) return detail::too_short();
        const mlrt_hits to = frame ? frame->c() : make<mlrt_hits>();
        Render render;
        render.callback = &callback;
        const int32_t code =
            mlrt_render_tiles(get(), &camera, &options, frame ? &to : nullptr, callback ? receive : nullptr, &render);
        Status status = detail::ended(code, options.host);
        if (render.thrown) status.set_thrown(render.thrown);
        return status;
    }

    /* 1 for each point that something hides from the light, else 0: mlrt_occluded_points. */
    Status try_occluded_points(const Points &points, const Light &light, Output<uint8_t> occluded,
                               const TraceOptions &options = TraceOptions()) const {
        detail::Lengths lengths;
        mlrt_points from = make<mlrt_points>();
        from.count = points.positions.count(), from.row_length = points.row_length;
        from.positions = lengths("points.positions", points.positions, from.count);
        from.skip = lengths("points.skip", points.skip, from.count);
        if (!lengths.result()) return lengths.result();
        if (!occluded.fits(from.count, 1)) return detail::too_short();
        uint8_t none;
        mlrt_array to = occluded.array();
        if (!from.count) to.data = &none; /* an empty container has no array */
        return detail::ended(mlrt_occluded_points(get(), &from, &light, &options, &to), options.host);
    }

    /* The ray that decides whether a light reaches a hit; without a direction, if the light is on the other side. */
    Result<Ray> try_shadow_ray(const Ray &ray, const Hit &hit, const Light &light) const {
        Result<Ray> result;
        mlrt_hit h = make<mlrt_hit>();
        h.mesh = hit.mesh, h.triangle = hit.triangle;
        int32_t faces;
        static_cast<Status &>(result) = Status::of(mlrt_shadow_ray(get(), &ray, &h, &light, &result.value, &faces));
        return result;
    }

    /* A point just off a triangle, on one side: mlrt_offset_point. */
    Result<std::array<float, 3>> try_offset_point(uint32_t mesh, uint32_t triangle, float u, float v,
                                                  int32_t side) const {
        Result<std::array<float, 3>> result;
        static_cast<Status &>(result) =
            Status::of(mlrt_offset_point(get(), mesh, triangle, u, v, side, result.value.data()));
        return result;
    }

#if MLRT_EXCEPTIONS
    /* The same as the functions above, but they throw, and some return vectors. */
    explicit Tree(const std::vector<mlrt_mesh> &meshes, const TreeOptions &options = TreeOptions())
        : Tree(try_build(meshes, options).take()) {}
    Tree(const std::vector<mlrt_mesh> &meshes, const KdTreeOptions &options)
        : Tree(try_build(meshes, options).take()) {}
    static Tree load(const std::vector<uint8_t> &bytes, const LoadOptions &options = LoadOptions()) {
        return try_load(bytes.data(), bytes.size(), options).take();
    }
    static Tree load(const void *data, size_t size, const LoadOptions &options = LoadOptions()) {
        return try_load(data, size, options).take();
    }
    mlrt_tree_info info() const { return try_info().take(); }
    std::vector<uint8_t> save() const { return try_save().take(); }

    void trace(const Rays &rays, const HitArrays &hits, const TraceOptions &options = TraceOptions()) const {
        try_trace(rays, hits, options).check();
    }
    /* The closest hit of each ray. */
    Hits trace(const Rays &rays, TraceOptions options = TraceOptions()) const {
        detail::check_count("rays.count", rays.count()).check();
        Hits hits(rays.count());
        options.query = MLRT_QUERY_CLOSEST;
        trace(rays, hits.arrays(), options);
        return hits;
    }
    Hits trace(const std::vector<float> &origins, const std::vector<float> &directions,
               const Pool *pool = nullptr) const {
        return trace(Rays(origins, directions), pool ? TraceOptions().set(*pool) : TraceOptions());
    }
    /* 1 for each ray that hits anything, else 0. */
    std::vector<uint8_t> occluded(const Rays &rays, TraceOptions options = TraceOptions()) const {
        detail::check_count("rays.count", rays.count()).check();
        std::vector<uint8_t> answers(rays.count());
        HitArrays arrays;
        arrays.occluded = answers;
        options.query = MLRT_QUERY_ANY;
        trace(rays, arrays, options);
        return answers;
    }
    Hit trace_ray(const Ray &ray, const TraceOptions &options = TraceOptions()) const {
        return try_trace_ray(ray, options).take();
    }
    bool occluded_ray(const Ray &ray, const TraceOptions &options = TraceOptions()) const {
        return try_occluded_ray(ray, options).take();
    }
    void all_hits(const Rays &rays, const HitListArrays &lists, const TraceOptions &options = TraceOptions()) const {
        try_all_hits(rays, lists, options).check();
    }
    HitLists all_hits(const Rays &rays, uint32_t capacity, const TraceOptions &options = TraceOptions()) const {
        detail::check_count("rays.count", rays.count()).check();
        HitLists lists(rays.count(), capacity);
        all_hits(rays, lists.arrays(), options);
        return lists;
    }
    void render(const Camera &camera, const HitArrays *frame, const TileCallback &callback,
                const TraceOptions &options = TraceOptions()) const {
        try_render(camera, frame, callback, options).check();
    }
    /* The closest hits of a camera's pixels, row by row. */
    Hits render(const Camera &camera, const TraceOptions &options = TraceOptions()) const {
        const size_t n = detail::product(camera.columns(), camera.rows());
        if (!detail::check_count("", n)) camera.rays(Output<float, 3>(), Output<float, 3>()); /* throws what is wrong */
        Hits hits(n);
        if (!hits.size()) Status(MLRT_ERROR_CAMERA, "camera: it has no pixels").check();
        const HitArrays arrays = hits.arrays();
        render(camera, &arrays, nullptr, options);
        return hits;
    }
    std::vector<uint8_t> occluded_points(const Points &points, const Light &light,
                                         const TraceOptions &options = TraceOptions()) const {
        detail::check_count("points.count", points.positions.count()).check();
        std::vector<uint8_t> occluded(points.positions.count());
        try_occluded_points(points, light, occluded, options).check();
        return occluded;
    }
    Ray shadow_ray(const Ray &ray, const Hit &hit, const Light &light) const {
        return try_shadow_ray(ray, hit, light).take();
    }
    std::array<float, 3> offset_point(uint32_t mesh, uint32_t triangle, float u, float v, int32_t side) const {
        return try_offset_point(mesh, triangle, u, v, side).take();
    }
#endif
};

#if MLRT_EXCEPTIONS
inline mlrt_memory_estimate estimate(const std::vector<mlrt_mesh> &meshes, const TreeOptions &options = TreeOptions()) {
    return try_estimate(meshes, options).take();
}
inline mlrt_memory_estimate estimate(const std::vector<mlrt_mesh> &meshes, const KdTreeOptions &options) {
    return try_estimate(meshes, options).take();
}
inline uint64_t hash_geometry(const std::vector<mlrt_mesh> &meshes) { return try_hash_geometry(meshes).take(); }
#endif

} // namespace mlrt

#endif
