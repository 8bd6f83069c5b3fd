/* Lets User-Mode Linux run on processors whose floating-point state is larger than it knows of (AMX: 11 KB).
 *
 * It saves and restores the state of its processes by ptrace in a buffer of a fixed size. The host fills what there is
 * room for, but takes back nothing that is incomplete, and the guest panics in its first process. Loaded before the C
 * library (LD_PRELOAD), this hands on the part that User-Mode Linux asks for, and gives back the whole.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/uio.h>

static char whole[1 << 16];

long ptrace(enum __ptrace_request request, ...)
{
    static long (*of_library)(enum __ptrace_request, ...);
    va_list given;
    va_start(given, request);
    int process = va_arg(given, int);
    void *address = va_arg(given, void *);
    void *data = va_arg(given, void *);
    va_end(given);

    if (!of_library)
        of_library = dlsym(RTLD_NEXT, "ptrace");
    if ((request != PTRACE_GETREGSET && request != PTRACE_SETREGSET) || (long)address != NT_X86_XSTATE)
        return of_library(request, process, address, data);

    struct iovec *part = data, all = {whole, sizeof whole};
    if (of_library(PTRACE_GETREGSET, process, address, &all) < 0)
        return -1;
    if (part->iov_len > all.iov_len)
        part->iov_len = all.iov_len;
    if (request == PTRACE_GETREGSET) {
        memcpy(part->iov_base, whole, part->iov_len);
        return 0;
    }
    memcpy(whole, part->iov_base, part->iov_len);
    return of_library(PTRACE_SETREGSET, process, address, &all);
}
