/* Preloaded, it hides AVX-512 and AMX from a process and those that it starts: numpy, LLVM, heyoka and this package
   then work as on a processor with AVX2 alone.  Linux on Intel: CPUID is made to fault, and answered here.

   Registers are EAX, EBX, ECX, EDX; bits are those of Intel's manual, volume 2A, CPUID. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#define ARCH_SET_CPUID 0x1012
#define ALDER_LAKE 0x00090672u /* a model without AVX-512: LLVM knows features by the model too */

static long allow_cpuid(int allowed) { return syscall(SYS_arch_prctl, ARCH_SET_CPUID, allowed); }

static void answer(int signal_number, siginfo_t *info, void *context) {
    greg_t *g = ((ucontext_t *)context)->uc_mcontext.gregs;
    const unsigned char *code = (const unsigned char *)g[REG_RIP];
    if (code[0] != 0x0f || code[1] != 0xa2) { /* another fault: let it end the process */
        signal(SIGSEGV, SIG_DFL);
        return;
    }
    uint32_t a = g[REG_RAX], b, c = g[REG_RCX], d, leaf = a, part = c;
    allow_cpuid(1);
    __asm__ volatile("cpuid" : "+a"(a), "=b"(b), "+c"(c), "=d"(d));
    allow_cpuid(0);
    if (leaf == 1) a = ALDER_LAKE;
    if (leaf == 7 && part == 0) {
        b &= ~0xdc230000u; /* F, DQ, IFMA, PF, ER, CD, BW, VL */
        c &= ~0x00005842u; /* VBMI, VBMI2, VNNI, BITALG, VPOPCNTDQ */
        d &= ~0x03c0010cu; /* 4VNNIW, 4FMAPS, VP2INTERSECT, AMX, FP16 */
    }
    if (leaf == 7 && part == 1) {
        a &= ~0x00000020u; /* BF16 */
        d &= ~0x00080000u; /* AVX10 */
    }
    if (leaf == 0xd && part == 0) a &= ~0x000600e0u; /* their registers */
    g[REG_RAX] = a, g[REG_RBX] = b, g[REG_RCX] = c, g[REG_RDX] = d, g[REG_RIP] += 2;
}

__attribute__((constructor)) static void hide(void) {
    struct sigaction action = {0};
    action.sa_sigaction = answer;
    action.sa_flags = SA_SIGINFO | SA_NODEFER;
    sigaction(SIGSEGV, &action, 0);
    if (allow_cpuid(0)) perror("AVX-512 cannot be hidden here");
}
