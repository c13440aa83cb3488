/* Loaded before libc (LD_PRELOAD): reads of a file called CATAMARAN_EIO_FILE fail with EIO once
   CATAMARAN_EIO_BYTES of such files were read. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static size_t done;

static int is_failing(int fd)
{
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    const char *name = getenv("CATAMARAN_EIO_FILE"), *last = strrchr(path, '/');
    return name && last && !strcmp(last + 1, name);
}

/* The bytes of n that may be read; 0 when it fails. */
static size_t allowed(size_t n)
{
    size_t most = strtoull(getenv("CATAMARAN_EIO_BYTES"), NULL, 10);
    return done >= most ? 0 : n < most - done ? n : most - done;
}

static ssize_t counted(ssize_t got)
{
    if (got > 0) done += (size_t)got;
    return got;
}

static ssize_t failed(void)
{
    errno = EIO;
    return -1;
}

ssize_t read(int fd, void *buffer, size_t n)
{
    ssize_t (*real)(int, void *, size_t) = dlsym(RTLD_NEXT, "read");
    if (!is_failing(fd)) return real(fd, buffer, n);
    return allowed(n) ? counted(real(fd, buffer, allowed(n))) : failed();
}

ssize_t pread64(int fd, void *buffer, size_t n, off64_t at)
{
    ssize_t (*real)(int, void *, size_t, off64_t) = dlsym(RTLD_NEXT, "pread64");
    if (!is_failing(fd)) return real(fd, buffer, n, at);
    return allowed(n) ? counted(real(fd, buffer, allowed(n), at)) : failed();
}
