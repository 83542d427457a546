/* Preloaded: the n-th call of one kind that concerns a file below a folder fails, as on a failing disk.

   The struct below is the file that FAILING_CALLS names. Whoever runs the test writes folder, kind, number and error;
   the calls of each kind are counted there, over all processes. A failing close closes, as on Linux; any other failing
   call does nothing. */

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum kind { OPEN, READ, WRITE, TRUNCATE, SYNC, RENAME, LINK, UNLINK, MKDIR, CLOSE, KINDS };

static struct control {
    char folder[512];
    long kind, number, error;
    long counts[KINDS];
} *control;

__attribute__((constructor)) static void begin(void)
{
    const char *name = getenv("FAILING_CALLS");
    int file = name ? open(name, O_RDWR | O_CLOEXEC) : -1;
    if (file < 0)
        return;
    void *shared = mmap(NULL, sizeof *control, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    control = shared == MAP_FAILED ? NULL : shared;
    close(file);
}

/* Whether a call of a kind on an absolute path is to fail; sets errno then. */
static int fails(enum kind kind, const char *path)
{
    size_t length = strlen(control->folder);
    if (strncmp(path, control->folder, length) || (path[length] && path[length] != '/'))
        return 0;
    long number = __atomic_fetch_add(&control->counts[kind], 1, __ATOMIC_SEQ_CST);
    if (kind != control->kind || number != control->number)
        return 0;
    errno = (int)control->error;
    return 1;
}

static int fails_of(enum kind kind, int file)
{
    char link[64], path[PATH_MAX];
    int before = errno;
    if (!control || !control->folder[0])
        return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    errno = before;
    if (length < 0)
        return 0;
    path[length] = 0;
    return fails(kind, path);
}

static int fails_at(enum kind kind, int folder, const char *name)
{
    char path[2 * PATH_MAX] = "", link[64];
    int before = errno;
    if (!control || !control->folder[0])
        return 0;
    if (name[0] == '/') {
        snprintf(path, sizeof path, "%s", name);
    } else {
        if (folder == AT_FDCWD)
            snprintf(link, sizeof link, "/proc/self/cwd");
        else
            snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
        ssize_t length = readlink(link, path, PATH_MAX - 1);
        errno = before;
        if (length < 0)
            return 0;
        snprintf(path + length, sizeof path - (size_t)length, "/%s", name);
    }
    errno = before;
    return fails(kind, path);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

#define MODE(flags) \
    mode_t mode = 0; \
    if ((flags) & (O_CREAT | __O_TMPFILE)) { \
        va_list rest; \
        va_start(rest, flags); \
        mode = va_arg(rest, mode_t); \
        va_end(rest); \
    }

#define FAILING_OPEN(name) \
    int name(const char *path, int flags, ...) \
    { \
        MODE(flags) \
        return fails_at(OPEN, AT_FDCWD, path) ? -1 : REAL(name)(path, flags, mode); \
    }
#define FAILING_OPENAT(name) \
    int name(int folder, const char *path, int flags, ...) \
    { \
        MODE(flags) \
        return fails_at(OPEN, folder, path) ? -1 : REAL(name)(folder, path, flags, mode); \
    }

FAILING_OPEN(open)
FAILING_OPEN(open64)
FAILING_OPENAT(openat)
FAILING_OPENAT(openat64)

FILE *fopen(const char *path, const char *mode)
{
    return fails_at(OPEN, AT_FDCWD, path) ? NULL : REAL(fopen)(path, mode);
}

FILE *fopen64(const char *path, const char *mode)
{
    return fails_at(OPEN, AT_FDCWD, path) ? NULL : REAL(fopen64)(path, mode);
}

DIR *opendir(const char *path)
{
    return fails_at(OPEN, AT_FDCWD, path) ? NULL : REAL(opendir)(path);
}

#define ON_FILE(kind, result, name, parameters, arguments) \
    result name parameters \
    { \
        return fails_of(kind, file) ? -1 : REAL(name) arguments; \
    }
#define AT_PATH(kind, name, parameters, folder, path, arguments) \
    int name parameters \
    { \
        return fails_at(kind, folder, path) ? -1 : REAL(name) arguments; \
    }

ON_FILE(READ, ssize_t, read, (int file, void *data, size_t size), (file, data, size))
ON_FILE(READ, ssize_t, pread, (int file, void *data, size_t size, off_t at), (file, data, size, at))
ON_FILE(READ, ssize_t, pread64, (int file, void *data, size_t size, off64_t at), (file, data, size, at))
ON_FILE(WRITE, ssize_t, write, (int file, const void *data, size_t size), (file, data, size))
ON_FILE(WRITE, ssize_t, pwrite, (int file, const void *data, size_t size, off_t at), (file, data, size, at))
ON_FILE(WRITE, ssize_t, pwrite64, (int file, const void *data, size_t size, off64_t at), (file, data, size, at))
ON_FILE(TRUNCATE, int, ftruncate, (int file, off_t size), (file, size))
ON_FILE(TRUNCATE, int, ftruncate64, (int file, off64_t size), (file, size))
ON_FILE(SYNC, int, fsync, (int file), (file))
ON_FILE(SYNC, int, fdatasync, (int file), (file))
AT_PATH(RENAME, rename, (const char *one, const char *other), AT_FDCWD, one, (one, other))
AT_PATH(RENAME, renameat, (int folder, const char *one, int there, const char *other), folder, one,
        (folder, one, there, other))
AT_PATH(LINK, link, (const char *one, const char *other), AT_FDCWD, one, (one, other))
AT_PATH(LINK, linkat, (int folder, const char *one, int there, const char *other, int flags), folder, one,
        (folder, one, there, other, flags))
AT_PATH(UNLINK, unlink, (const char *path), AT_FDCWD, path, (path))
AT_PATH(UNLINK, rmdir, (const char *path), AT_FDCWD, path, (path))
AT_PATH(UNLINK, unlinkat, (int folder, const char *path, int flags), folder, path, (folder, path, flags))
AT_PATH(MKDIR, mkdir, (const char *path, mode_t mode), AT_FDCWD, path, (path, mode))
AT_PATH(MKDIR, mkdirat, (int folder, const char *path, mode_t mode), folder, path, (folder, path, mode))

int close(int file)
{
    int failing = fails_of(CLOSE, file), error = errno;
    int result = REAL(close)(file);
    if (!failing)
        return result;
    errno = error;
    return -1;
}
