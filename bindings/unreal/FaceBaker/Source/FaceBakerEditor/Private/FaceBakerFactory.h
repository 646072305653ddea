#pragma once

#include "CoreMinimal.h"
#include "Factories/Factory.h"

#include "FaceBakerFactory.generated.h"

/** Imports .fbk archives as assets; one that is damaged is refused with the library's message. */
UCLASS()
class UFaceBakerFactory : public UFactory {
  GENERATED_BODY()

 public:
  UFaceBakerFactory(const FObjectInitializer& Initializer);

  virtual UObject* FactoryCreateFile(UClass* InClass, UObject* InParent, FName InName, EObjectFlags Flags,
                                     const FString& Filename, const TCHAR* Parameters, FFeedbackContext* Warnings,
                                     bool& bCancelled) override;
};
