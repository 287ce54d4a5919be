/* SPDX-License-Identifier: MIT */
/* Prints the layout of all structs, or with an argument the constants: tests/abi/layout-*.txt and constants.txt. */
#include "interface.h"

int main(int argc, char **argv)
{
    (void)argv;
    if (argc > 1)
        print_constants(stdout);
    else
        print_layout(stdout);
    return 0;
}
